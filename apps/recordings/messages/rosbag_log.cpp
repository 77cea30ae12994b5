#include "recordings/messages/message_log.h"

#ifdef FUSE_FLOW_WITH_ROSBAG
#include <console_bridge/console.h>
#include <ros/serialization.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#endif

#include <map>

namespace fuse_flow::io {

#ifndef FUSE_FLOW_WITH_ROSBAG

std::unique_ptr<MessageLog> openRosBag(const std::string& path) {
  throw InputError(
      path +
      ": cannot be read, since FUSE-Flow was built without rosbag; install librosbag-storage-dev, and build "
      "it again");
}

#else

namespace {

/** \brief Keeps ROS from printing while it lives: what matters is thrown. */
class SilenceRos {
 public:
  SilenceRos() { console_bridge::noOutputHandler(); }
  ~SilenceRos() { console_bridge::restorePreviousOutputHandler(); }
  SilenceRos(const SilenceRos&) = delete;
  SilenceRos& operator=(const SilenceRos&) = delete;
};

class RosBagLog : public MessageLog {
 public:
  explicit RosBagLog(const std::string& path) {
    path_ = path;
    const SilenceRos silence;
    try {
      bag_.open(path, rosbag::bagmode::Read);
      // Sorted by time, of all connections; what is kept of a message is where it is.
      rosbag::View view(bag_);
      std::map<std::string, std::size_t> numbers;
      for (const rosbag::MessageInstance& message : view) {
        const auto [known, added] = numbers.emplace(message.getTopic(), topics_.size());
        if (added) {
          topics_.push_back({message.getTopic(), message.getDataType(), Wire::Ros1, {}});
          messages_.emplace_back();
        }
        topics_[known->second].times.push_back(static_cast<Nanoseconds>(message.getTime().toNSec()));
        messages_[known->second].push_back(message);
      }
    } catch (const rosbag::BagUnindexedException&) {
      throw InputError(path + ": was not closed when it was recorded, and has no index; `rosbag reindex` makes one");
    } catch (const rosbag::BagException& error) {
      throw InputError(path + ": cannot be read: " + error.what());
    } catch (const std::runtime_error& error) {  // of its compression
      throw InputError(path + ": is damaged: " + error.what());
    }
  }

  void read(std::size_t topic, std::size_t message, std::string& bytes) override {
    const rosbag::MessageInstance& instance = messages_.at(topic).at(message);
    const SilenceRos silence;
    try {
      bytes.resize(instance.size());
      ros::serialization::OStream out(reinterpret_cast<std::uint8_t*>(bytes.data()), instance.size());
      instance.write(out);
    } catch (const std::exception& error) {  // rosbag's, and those of its compression
      throw InputError(path_ + ": message " + std::to_string(message) + " of " + topics_[topic].name +
                       " is damaged: " + error.what());
    }
  }

 private:
  rosbag::Bag bag_;
  std::vector<std::vector<rosbag::MessageInstance> > messages_;  // of each topic
};

}  // namespace

std::unique_ptr<MessageLog> openRosBag(const std::string& path) { return std::make_unique<RosBagLog>(path); }

#endif

}  // namespace fuse_flow::io
