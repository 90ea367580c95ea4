"""CRC-32C (Castagnoli): computed by the package crc32c if installed, otherwise by numpy."""

from typing import List

import numpy as np

try:
    from crc32c import crc32c as extend_crc32c_natively
except ImportError:  # Faster, but optional.
    extend_crc32c_natively = None

_REFLECTED_POLYNOMIAL = np.uint32(0x82F63B78)
_LANE_BYTES = 64  # A power of two.


def extend_crc32c(crc: int, data: bytes) -> int:
    """Returns the CRC-32C of data with the CRC-32C `crc`, followed by `data`. Start with 0."""
    if extend_crc32c_natively is not None:
        return extend_crc32c_natively(data, crc)
    return extend_crc32c_with_numpy(crc, data)


def extend_crc32c_with_numpy(crc: int, data: bytes) -> int:
    """Implements `extend_crc32c` with numpy; about 3 ms for 460 kB.

    Splits the data into lanes, advances all of them at once, and joins neighbours: the register of
    A followed by B is the register of A after len(B) zero bytes, XOR the register of B.
    """
    if not data:
        return crc
    lanes = 1 << max(0, (len(data) - 1) // _LANE_BYTES).bit_length()
    padded = np.zeros(lanes * _LANE_BYTES, np.uint8)  # Leading zeros keep a zero register.
    padded[padded.size - len(data) :] = np.frombuffer(data, np.uint8)
    registers = np.zeros(lanes, np.uint32)
    for column in np.ascontiguousarray(padded.reshape(lanes, _LANE_BYTES).T):
        registers = _BYTE_TABLE[(registers ^ column) & 0xFF] ^ (registers >> 8)
    length = _LANE_BYTES
    while registers.size > 1:
        registers = _after_zeros(registers[0::2], length) ^ registers[1::2]
        length *= 2
    start = np.array([crc ^ 0xFFFFFFFF], np.uint32)
    return int(registers[0] ^ _after_zeros(start, len(data))[0]) ^ 0xFFFFFFFF


def _make_byte_table() -> np.ndarray:
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ _REFLECTED_POLYNOMIAL, table >> 1)
    return table


_BYTE_TABLE = _make_byte_table()


def _apply(images: np.ndarray, registers: np.ndarray) -> np.ndarray:
    """Applies a linear map, given by the images of the 32 single bits, to each register."""
    result = np.zeros_like(registers)
    for bit in range(32):
        result ^= np.where((registers >> np.uint32(bit)) & 1, images[bit], np.uint32(0))
    return result


def _make_zero_maps() -> List[np.ndarray]:
    """Returns the linear maps that 1, 2, 4, ... zero bytes apply to a register."""
    bits = np.uint32(1) << np.arange(32, dtype=np.uint32)
    maps = [_BYTE_TABLE[bits & 0xFF] ^ (bits >> 8)]
    for _ in range(40):
        maps.append(_apply(maps[-1], maps[-1]))
    return maps


_ZERO_MAPS = _make_zero_maps()


def _after_zeros(registers: np.ndarray, count: int) -> np.ndarray:
    for power, images in enumerate(_ZERO_MAPS):
        if count >> power & 1:
            registers = _apply(images, registers)
    return registers
