#include "component_name/algorithm.hpp"

#include <algorithm>

namespace component_name
{
std::optional<Point> find(const std::vector<Point> & points)
{
  const auto lower = [](const Point & a, const Point & b) {return a[2] < b[2];};
  const auto highest = std::max_element(points.begin(), points.end(), lower);
  return highest == points.end() ? std::nullopt : std::optional<Point>(*highest);
}
}  // namespace component_name
