#include <cstdio>

#include "component_name/algorithm.hpp"

int main()
{
  const auto found = component_name::find({{0.0, 0.0, 0.1}, {0.2, 0.0, 0.3}, {0.0, 0.1, 0.2}});
  const bool right = found && (*found)[0] == 0.2 && (*found)[2] == 0.3;
  const bool none = !component_name::find({});
  std::printf("highest: %s, empty: %s\n", right ? "ok" : "WRONG", none ? "ok" : "WRONG");
  return right && none ? 0 : 1;
}
