#pragma once

#include <span>

#include "core/types/policy_parameters.h"

namespace steadymap {

/// Parameters of the belief, in both variants of POCD.
inline constexpr PolicyParameter kInitialStationarity = {
    "initial_stationarity", 0.67, 0.01, 0.99, false, "E[v] of a new object (v_class)"};
inline constexpr PolicyParameter kMaxStationarity = {
    "max_stationarity", 0.9999, 0.5, 0.999999, false, "largest E[v] (v_max)"};
inline constexpr PolicyParameter kChangeNoise = {
    "change_noise_m",
    0.2,
    0.001,
    10.0,
    false,
    "standard deviation of the measured change of an object that stays (tau)"};
inline constexpr PolicyParameter kMaxChange = {
    "max_change_m", 4.0, 0.01, 100.0, false, "largest measured change (delta_max)"};
inline constexpr PolicyParameter kStationarityWeight = {
    "stationarity_weight",
    3.0,
    0.0,
    100.0,
    false,
    "weight of the class in agreement with the measurement (k)"};

/// Returns the parameters of the policy `pocd`.
std::span<const PolicyParameter> PocdParameters();

}  // namespace steadymap
