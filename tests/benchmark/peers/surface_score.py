"""Scores surfaces against a reference surface: accuracy and completeness, by local bend.

    python3 surface_score.py --reference reference.ply --radius 0.02 map.ply open3d.ply

Accuracy is the share of the surface within the radius of the reference, completeness the share of
the reference within the radius of the surface. The bend of a place of the reference is the RMS
distance of the reference within 4 cm from its best plane: some 7.5 mm at a right-angled edge.
A file without triangles is a point cloud. Needs Debian's `python3-open3d`.
"""

import argparse

import numpy
import open3d

BEND_RADIUS_M = 0.04
BEND_CLASSES_MM = [(0.0, 3.0), (3.0, 6.0), (6.0, 10.0), (10.0, numpy.inf)]
SPACING_M = 0.005
MAX_BEND_POINTS = 60_000


def sample(path):
    """Returns points of a surface, one per SPACING_M squared, and the triangle count."""
    mesh = open3d.io.read_triangle_mesh(str(path))
    if len(mesh.triangles) == 0:
        return open3d.io.read_point_cloud(str(path)), 0
    count = max(1, int(mesh.get_surface_area() / SPACING_M**2))
    open3d.utility.random.seed(1)
    return mesh.sample_points_uniformly(count), len(mesh.triangles)


def share(distances_m, radius_m):
    return 100.0 * numpy.mean(numpy.asarray(distances_m) <= radius_m)


def bend_mm(cloud, indices):
    """Returns the RMS distance from the best plane of the points around each point."""
    tree = open3d.geometry.KDTreeFlann(cloud)
    points = numpy.asarray(cloud.points)
    bends = numpy.zeros(len(indices))
    for row, index in enumerate(indices):
        _, near, _ = tree.search_radius_vector_3d(points[index], BEND_RADIUS_M)
        if len(near) < 4:
            bends[row] = numpy.inf
            continue
        covariance = numpy.cov(points[numpy.asarray(near)].T)
        bends[row] = 1e3 * numpy.sqrt(max(0.0, numpy.linalg.eigvalsh(covariance)[0]))
    return bends


def print_scores(reference_path, paths, radius_m):
    """Prints one line per surface."""
    reference, _ = sample(reference_path)
    generator = numpy.random.default_rng(1)
    count = len(reference.points)
    chosen = generator.choice(count, min(count, MAX_BEND_POINTS), replace=False)
    bends = bend_mm(reference, chosen)
    classes = [(bends >= low) & (bends < high) for low, high in BEND_CLASSES_MM]
    heading = "".join(f"{f'{low:g}-{high:g}':>8}" for low, high in BEND_CLASSES_MM)
    title = f"share within {1e3 * radius_m:g} mm, %"
    print(f"{title:40} triangles  accuracy    complete  by local bend, mm")
    print(f"{'':71}{heading}")
    shares = "".join(f"{100.0 * numpy.mean(rows):8.1f}" for rows in classes)
    print(f"{'share of the reference':71}{shares}")
    for path in paths:
        surface, triangles = sample(path)
        accuracy = share(surface.compute_point_cloud_distance(reference), radius_m)
        distances_m = numpy.asarray(reference.compute_point_cloud_distance(surface))
        by_bend = "".join(
            f"{share(distances_m[chosen[rows]], radius_m):8.1f}" if rows.any() else f"{'-':>8}"
            for rows in classes
        )
        complete = share(distances_m, radius_m)
        print(f"{str(path)[-40:]:40} {triangles:9}  {accuracy:8.1f}  {complete:10.1f}{by_bend}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surfaces", nargs="+", help="PLY files")
    parser.add_argument("--reference", required=True, help="a PLY file")
    parser.add_argument("--radius", type=float, default=0.02, help="metres")
    arguments = parser.parse_args()
    print_scores(arguments.reference, arguments.surfaces, arguments.radius)


if __name__ == "__main__":
    main()
