// What the component does; to be replaced by your own. Nothing here knows ROS.
#pragma once

#include <array>
#include <optional>
#include <vector>

namespace component_name
{
using Point = std::array<double, 3>;  // [m]

// Return the highest point, or nothing when there is no point.
std::optional<Point> find(const std::vector<Point> & points);
}  // namespace component_name
