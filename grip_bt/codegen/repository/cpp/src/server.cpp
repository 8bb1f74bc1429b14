// Serves the algorithm as a ROS 2 service. Plain rclcpp; nothing here knows who calls.
#include <memory>
#include <vector>

#include "component_name/algorithm.hpp"
#include "component_name_interfaces/srv/component_name.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/point_cloud2_iterator.hpp"

using Service = component_name_interfaces::srv::ComponentName;
constexpr int8_t kFound = 0;  // the outcomes, as component.yaml names them
constexpr int8_t kNone = 1;

std::vector<component_name::Point> points_of(const sensor_msgs::msg::PointCloud2 & cloud)
{
  std::vector<component_name::Point> points;
  if (cloud.width * cloud.height == 0) {
    return points;
  }
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (; x != x.end(); ++x, ++y, ++z) {
    points.push_back({*x, *y, *z});
  }
  return points;
}

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  const auto node = std::make_shared<rclcpp::Node>("component_name");
  const auto service = node->create_service<Service>(
    "/component_name",
    [](const std::shared_ptr<Service::Request> request, std::shared_ptr<Service::Response> response) {
      const auto found = component_name::find(points_of(request->input));
      response->outcome = found ? kFound : kNone;
      if (found) {
        response->returned_object.header = request->input.header;
        response->returned_object.pose.position.x = (*found)[0];
        response->returned_object.pose.position.y = (*found)[1];
        response->returned_object.pose.position.z = (*found)[2];
        response->returned_object.pose.orientation.w = 1.0;
      }
    });
  rclcpp::spin(node);
  rclcpp::shutdown();
  return 0;
}
