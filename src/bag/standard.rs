//! Standard types that carom sends, hears or records: their fields, in the order of the wire.
//!
//! Constants and comments are left out: neither is on the wire, nor in the hash of a type.

/// Name and fields of each.
pub const STANDARD: &[(&str, &str)] = &[
    (
        "ateam_msgs/msg/VisionStateBall",
        "geometry_msgs/Pose pose\ngeometry_msgs/Twist twist\ngeometry_msgs/Accel accel\n\
         bool visible\n",
    ),
    (
        "ateam_msgs/msg/VisionStateRobot",
        "geometry_msgs/Pose pose\ngeometry_msgs/Twist twist\ngeometry_msgs/Twist twist_body\n\
         geometry_msgs/Accel accel\nbool visible\n",
    ),
    ("builtin_interfaces/msg/Duration", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec\n"),
    ("diagnostic_msgs/msg/DiagnosticArray", "std_msgs/Header header\nDiagnosticStatus[] status\n"),
    (
        "diagnostic_msgs/msg/DiagnosticStatus",
        "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values\n",
    ),
    ("diagnostic_msgs/msg/KeyValue", "string key\nstring value\n"),
    ("geometry_msgs/msg/Accel", "Vector3 linear\nVector3 angular\n"),
    ("geometry_msgs/msg/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/msg/Pose", "Point position\nQuaternion orientation\n"),
    ("geometry_msgs/msg/Pose2D", "float64 x\nfloat64 y\nfloat64 theta\n"),
    ("geometry_msgs/msg/PoseArray", "std_msgs/Header header\nPose[] poses\n"),
    ("geometry_msgs/msg/PoseStamped", "std_msgs/Header header\nPose pose\n"),
    ("geometry_msgs/msg/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n"),
    (
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "std_msgs/Header header\nPoseWithCovariance pose\n",
    ),
    ("geometry_msgs/msg/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"),
    ("geometry_msgs/msg/Transform", "Vector3 translation\nQuaternion rotation\n"),
    (
        "geometry_msgs/msg/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
    ),
    ("geometry_msgs/msg/Twist", "Vector3 linear\nVector3 angular\n"),
    ("geometry_msgs/msg/TwistStamped", "std_msgs/Header header\nTwist twist\n"),
    ("geometry_msgs/msg/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n"),
    ("geometry_msgs/msg/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "nav_msgs/msg/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
    ),
    (
        "rcl_interfaces/msg/Log",
        "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\n\
         string function\nuint32 line\n",
    ),
    ("rcl_interfaces/msg/Parameter", "string name\nParameterValue value\n"),
    (
        "rcl_interfaces/msg/ParameterEvent",
        "builtin_interfaces/Time stamp\nstring node\nParameter[] new_parameters\n\
         Parameter[] changed_parameters\nParameter[] deleted_parameters\n",
    ),
    (
        "rcl_interfaces/msg/ParameterValue",
        "uint8 type\nbool bool_value\nint64 integer_value\nfloat64 double_value\n\
         string string_value\nbyte[] byte_array_value\nbool[] bool_array_value\n\
         int64[] integer_array_value\nfloat64[] double_array_value\nstring[] string_array_value\n",
    ),
    (
        "robocup_ssl_msgs/msg/KickedBall",
        "Vector2 pos\nVector3 vel\nfloat64 start_timestamp\nfloat64[<=1] stop_timestamp\n\
         Vector2[<=1] stop_pos\nRobotId[<=1] robot_id\n",
    ),
    ("robocup_ssl_msgs/msg/RobotId", "uint32 id\nuint32 team_color\n"),
    (
        "robocup_ssl_msgs/msg/TrackedBall",
        "Vector3 pos\nVector3[<=1] vel\nfloat32[<=1] visibility\n",
    ),
    (
        "robocup_ssl_msgs/msg/TrackedFrame",
        "uint32 frame_number\nfloat64 timestamp\nTrackedBall[] balls\nTrackedRobot[] robots\n\
         KickedBall[<=1] kicked_ball\nuint32[] capabilities\n",
    ),
    (
        "robocup_ssl_msgs/msg/TrackedRobot",
        "RobotId robot_id\nVector2 pos\nfloat32 orientation\nVector2[<=1] vel\n\
         float32[<=1] vel_angular\nfloat32[<=1] visibility\n",
    ),
    ("robocup_ssl_msgs/msg/Vector2", "float32 x\nfloat32 y\n"),
    ("robocup_ssl_msgs/msg/Vector3", "float32 x\nfloat32 y\nfloat32 z\n"),
    ("rosgraph_msgs/msg/Clock", "builtin_interfaces/Time clock\n"),
    ("sensor_msgs/msg/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("std_msgs/msg/Bool", "bool data\n"),
    ("std_msgs/msg/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("std_msgs/msg/Float64", "float64 data\n"),
    ("std_msgs/msg/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/msg/Int32", "int32 data\n"),
    ("std_msgs/msg/String", "string data\n"),
    ("tf2_msgs/msg/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    (
        "visualization_msgs/msg/Marker",
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n\
         geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n\
         builtin_interfaces/Duration lifetime\nbool frame_locked\n\
         geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
         sensor_msgs/CompressedImage texture\nUVCoordinate[] uv_coordinates\nstring text\n\
         string mesh_resource\nMeshFile mesh_file\nbool mesh_use_embedded_materials\n",
    ),
    ("visualization_msgs/msg/MarkerArray", "Marker[] markers\n"),
    ("visualization_msgs/msg/MeshFile", "string filename\nuint8[] data\n"),
    ("visualization_msgs/msg/UVCoordinate", "float32 u\nfloat32 v\n"),
];
