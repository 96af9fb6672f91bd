//! The messages of ROS 2 that the tests need, as their definitions have them.

use ros2_client::{Message, MessageTypeName};
use serde::{Deserialize, Serialize};

macro_rules! message {
    ($name:ident, $package:literal { $($field:ident: $kind:ty),* $(,)? }) => {
        #[derive(Clone, Debug, Default, Serialize, Deserialize)]
        pub struct $name { $(pub $field: $kind),* }
        impl Message for $name {}
        impl $name {
            #[allow(dead_code)]
            pub fn kind() -> MessageTypeName {
                MessageTypeName::new($package, stringify!($name))
            }
        }
    };
}

message!(Time, "builtin_interfaces" { sec: i32, nanosec: u32 });
message!(Header, "std_msgs" { stamp: Time, frame_id: String });
message!(Empty, "std_msgs" { structure_needs_at_least_one_member: u8 });
message!(Image, "sensor_msgs" {
    header: Header, height: u32, width: u32, encoding: String, is_bigendian: u8, step: u32,
    data: Vec<u8>,
});
message!(RegionOfInterest, "sensor_msgs" {
    x_offset: u32, y_offset: u32, height: u32, width: u32, do_rectify: bool,
});
message!(CameraInfo, "sensor_msgs" {
    header: Header, height: u32, width: u32, distortion_model: String, d: Vec<f64>, k: [f64; 9],
    r: [f64; 9], p: [f64; 12], binning_x: u32, binning_y: u32, roi: RegionOfInterest,
});
message!(PointField, "sensor_msgs" { name: String, offset: u32, datatype: u8, count: u32 });
message!(PointCloud2, "sensor_msgs" {
    header: Header, height: u32, width: u32, fields: Vec<PointField>, is_bigendian: bool,
    point_step: u32, row_step: u32, data: Vec<u8>, is_dense: bool,
});
message!(Vector3, "geometry_msgs" { x: f64, y: f64, z: f64 });
message!(Quaternion, "geometry_msgs" { x: f64, y: f64, z: f64, w: f64 });
message!(Pose, "geometry_msgs" { position: Vector3, orientation: Quaternion });
message!(PoseStamped, "geometry_msgs" { header: Header, pose: Pose });
message!(Twist, "geometry_msgs" { linear: Vector3, angular: Vector3 });
// 36 numbers in a row; serde knows arrays of up to 32.
message!(PoseWithCovariance, "geometry_msgs" { pose: Pose, covariance: [[f64; 6]; 6] });
message!(TwistWithCovariance, "geometry_msgs" { twist: Twist, covariance: [[f64; 6]; 6] });
message!(Transform, "geometry_msgs" { translation: Vector3, rotation: Quaternion });
message!(TransformStamped, "geometry_msgs" {
    header: Header, child_frame_id: String, transform: Transform,
});
message!(TFMessage, "tf2_msgs" { transforms: Vec<TransformStamped> });
message!(Odometry, "nav_msgs" {
    header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance,
});
message!(Path, "nav_msgs" { header: Header, poses: Vec<PoseStamped> });
message!(ObjectHypothesis, "vision_msgs" { class_id: String, score: f64 });
message!(ObjectHypothesisWithPose, "vision_msgs" {
    hypothesis: ObjectHypothesis, pose: PoseWithCovariance,
});
message!(BoundingBox3D, "vision_msgs" { center: Pose, size: Vector3 });
message!(Detection3D, "vision_msgs" {
    header: Header, results: Vec<ObjectHypothesisWithPose>, bbox: BoundingBox3D, id: String,
});
message!(Detection3DArray, "vision_msgs" { header: Header, detections: Vec<Detection3D> });
message!(KeyValue, "diagnostic_msgs" { key: String, value: String });
message!(DiagnosticStatus, "diagnostic_msgs" {
    level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue>,
});
message!(DiagnosticArray, "diagnostic_msgs" { header: Header, status: Vec<DiagnosticStatus> });
