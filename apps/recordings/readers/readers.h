#pragma once

#include <fuse_flow/recordings/recording.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

// Each format in a file of its own, reader_FORMAT.cpp: how to recognise its folder, and how to open it.

bool isRigFolder(const std::string& folder);
/** \brief rig.json and NAME/{depth,color,confidence}/NNNNNN.png */
std::unique_ptr<Recording> openRig(const std::string& json_path, const RecordingOptions& options);

bool isSevenScenesFolder(const std::string& folder);
/** \brief frame-NNNNNN.{depth.png,color.jpg,pose.txt} */
std::unique_ptr<Recording> openSevenScenes(const std::string& folder, const RecordingOptions& options);

bool isTumFolder(const std::string& folder);
/** \brief depth.txt, rgb.txt, groundtruth.txt */
std::unique_ptr<Recording> openTum(const std::string& folder, const RecordingOptions& options);

bool isRedwoodFolder(const std::string& folder);
/** \brief depth/, color/ or image/, a trajectory .log or camera_trajectory.json, an intrinsics .json */
std::unique_ptr<Recording> openRedwood(const std::string& folder, const RecordingOptions& options);

bool isMvsnetFolder(const std::string& folder);
/** \brief cams/NAME_cam.txt, images/NAME.jpg, depth_est/NAME.pfm, confidence/NAME.pfm, as MVSNet and its successors have them */
std::unique_ptr<Recording> openMvsnet(const std::string& folder, const RecordingOptions& options);

bool isColmapFolder(const std::string& folder);
/** \brief sparse/, images/, stereo/depth_maps/NAME.{geometric,photometric}.bin: COLMAP's workspace of undistorted images */
std::unique_ptr<Recording> openColmap(const std::string& folder, const RecordingOptions& options);

bool isPcdFile(const std::string& path);
/** \brief Organised PCD files, each a camera of the one instant. */
std::unique_ptr<Recording> openPcd(const std::vector<std::string>& paths, const RecordingOptions& options);

/** \brief Whether a folder is one of those above, or a bag of ROS 2. */
bool isRecordingFolder(const std::string& folder);

bool isMkvFile(const std::string& path);
/** \brief Files of an Azure Kinect's or an Orbbec Femto's recorder, one for each camera. */
std::unique_ptr<Recording> openMkv(const std::vector<std::string>& paths, const RecordingOptions& options);

bool isVideoFile(const std::string& path);
/** \brief Videos of colour cameras, one for each, whose intrinsics and poses RecordingOptions::poses says. */
std::unique_ptr<Recording> openVideos(const std::vector<std::string>& paths, const RecordingOptions& options);

bool isMessageLog(const std::string& path);
/** \brief Bags of ROS 1, RealSense and ROS 2 (.bag, .mcap, .db3, or the folder with their metadata.yaml), each with one camera or several. */
std::unique_ptr<Recording> openMessageLogs(const std::vector<std::string>& paths, const RecordingOptions& options);

}  // namespace fuse_flow::io
