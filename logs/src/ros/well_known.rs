//! Definitions of common messages, for bags without any: ROS 2 before Iron wrote none.

use std::fmt::Write as _;

use super::definition::short_name;

const VECTOR: &str = "geometry_msgs/Vector3";
const LINE: &str = "================================================================================";

/// Fields of a type, and the types that these require.
type Known = (&'static str, &'static str, &'static [&'static str]);

/// Of several with one name the last release comes first.
const KNOWN: [Known; 22] = [
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
        &[],
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance",
        &["geometry_msgs/Quaternion", VECTOR],
    ),
    (
        "trajectory_msgs/JointTrajectory",
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points",
        &["trajectory_msgs/JointTrajectoryPoint"],
    ),
    (
        "trajectory_msgs/JointTrajectoryPoint",
        "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n\
         builtin_interfaces/Duration time_from_start",
        &[],
    ),
    // As in ROS 2 Humble, the last release whose bags hold no definitions.
    (
        "control_msgs/JointTrajectoryControllerState",
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint reference\n\
         trajectory_msgs/JointTrajectoryPoint feedback\ntrajectory_msgs/JointTrajectoryPoint error\n\
         trajectory_msgs/JointTrajectoryPoint output\ntrajectory_msgs/JointTrajectoryPoint desired\n\
         trajectory_msgs/JointTrajectoryPoint actual\nstring[] multi_dof_joint_names\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_reference\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_feedback\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_output\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual",
        &[
            "trajectory_msgs/JointTrajectoryPoint",
            "trajectory_msgs/MultiDOFJointTrajectoryPoint",
            "geometry_msgs/Transform",
            "geometry_msgs/Quaternion",
            "geometry_msgs/Twist",
            VECTOR,
        ],
    ),
    // As in ROS 2 Foxy.
    (
        "control_msgs/JointTrajectoryControllerState",
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint desired\n\
         trajectory_msgs/JointTrajectoryPoint actual\ntrajectory_msgs/JointTrajectoryPoint error",
        &["trajectory_msgs/JointTrajectoryPoint"],
    ),
    (
        "control_msgs/DynamicJointState",
        "std_msgs/Header header\nstring[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values",
        &["control_msgs/InterfaceValue"],
    ),
    ("control_msgs/InterfaceValue", "string[] interface_names\nfloat64[] values", &[]),
    (
        "trajectory_msgs/MultiDOFJointTrajectoryPoint",
        "geometry_msgs/Transform[] transforms\ngeometry_msgs/Twist[] velocities\n\
         geometry_msgs/Twist[] accelerations\nbuiltin_interfaces/Duration time_from_start",
        &["geometry_msgs/Transform", "geometry_msgs/Quaternion", "geometry_msgs/Twist", VECTOR],
    ),
    (
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
        &["geometry_msgs/Quaternion", VECTOR],
    ),
    (
        "geometry_msgs/WrenchStamped",
        "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
        &["geometry_msgs/Wrench", VECTOR],
    ),
    ("geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque", &[VECTOR]),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z", &[]),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w", &[]),
    (
        "geometry_msgs/TwistStamped",
        "std_msgs/Header header\ngeometry_msgs/Twist twist",
        &["geometry_msgs/Twist", VECTOR],
    ),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular", &[VECTOR]),
    ("std_msgs/Float64", "float64 data", &[]),
    ("std_msgs/Float32", "float32 data", &[]),
    (
        "std_msgs/Float64MultiArray",
        "std_msgs/MultiArrayLayout layout\nfloat64[] data",
        &["std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension"],
    ),
    (
        "std_msgs/Float32MultiArray",
        "std_msgs/MultiArrayLayout layout\nfloat32[] data",
        &["std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension"],
    ),
    (
        "std_msgs/MultiArrayLayout",
        "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset",
        &["std_msgs/MultiArrayDimension"],
    ),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride", &[]),
];

/// The definitions of a common message in different releases, as schemas of encoding `ros2msg`.
pub(crate) fn well_known(name: &str) -> Vec<String> {
    let of = |name: &str| KNOWN.iter().find(|(known, ..)| *known == name);
    let name = short_name(name);
    let whole = |(_, fields, needs): &Known| {
        let mut text = (*fields).to_owned();
        for (other, fields, _) in needs.iter().filter_map(|need| of(need)) {
            let _ = write!(text, "\n{LINE}\nMSG: {other}\n{fields}");
        }
        text
    };
    KNOWN.iter().filter(|(known, ..)| *known == name).map(whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_common_message_is_complete() {
        for (name, ..) in KNOWN {
            let texts = well_known(name);
            assert!(!texts.is_empty(), "{name}");
            for text in texts {
                assert!(super::super::definition("ros2msg", name, &text).is_ok(), "{name}");
            }
        }
        assert!(well_known("a/B").is_empty());
    }
}
