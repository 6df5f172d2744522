//! The table of the node's parameters: names, defaults, ranges and what they are for.

use super::parameters::{Declaration, Range};
use crate::centre::Estimator;
use crate::centre::photometric::{PsfChoice, ResponseGamma};
use ros2_client::ParameterValue;

/// Every parameter of the node but `use_sim_time`, which every ROS node has.
pub fn declarations() -> Vec<Declaration> {
    let text = |value: &str| ParameterValue::String(value.to_owned());
    let plain = |name, default, description| Declaration {
        name,
        default,
        description,
        constraints: String::new(),
        range: Range::Any,
        number_as_text: false,
    };
    let estimators = Estimator::ALL.map(Estimator::name).join(", ");
    let psfs = PsfChoice::ALL.map(PsfChoice::name).join(", ");
    vec![
        plain(
            "board_file",
            text(""),
            "Path of the board file (YAML) that describes the printed board. Required. Setting it starts the calibration anew.",
        ),
        Declaration {
            constraints: "raw".to_owned(),
            ..plain(
                "image_transport",
                text("raw"),
                "How the frames arrive: raw is sensor_msgs/msg/Image on the topic image.",
            )
        },
        Declaration {
            constraints: format!("one of {estimators}"),
            ..plain(
                "estimator",
                text(Estimator::default().name()),
                "How the projected centre of a ring is found. Setting it starts the calibration anew.",
            )
        },
        Declaration {
            constraints: format!("one of {psfs}"),
            ..plain(
                "psf",
                text(PsfChoice::default().name()),
                "Shape of the blur that the estimator photometric fits; auto takes the likelier. Setting it starts the \
                 calibration anew.",
            )
        },
        Declaration {
            constraints: format!(
                "auto or a number from {} to {}",
                ResponseGamma::LEAST,
                ResponseGamma::GREATEST
            ),
            number_as_text: true,
            ..plain(
                "response_gamma",
                text(&ResponseGamma::default().to_string()),
                "How grey values follow the light, for the estimator photometric: grey = light^(1/gamma); auto estimates \
                 gamma. Setting it starts the calibration anew.",
            )
        },
        Declaration {
            range: Range::Integers(0, 10_000),
            ..plain(
                "required_rings",
                ParameterValue::Integer(0),
                "How many rings of the board must be seen. 0: one in every row and column, and 60 % of all; with fewer rows \
                 or columns the numbers begin at the first that were seen.",
            )
        },
        Declaration {
            constraints: "one of plumb_bob, rational_polynomial, equidistant, auto".to_owned(),
            ..plain(
                "model",
                text("plumb_bob"),
                "Lens model of the calibration; auto takes the one that predicts left-out views best.",
            )
        },
        Declaration {
            constraints:
                "a list of the model's parameters (fx, fy, cx, cy, k1, k2, p1, p2, k3, ...), each with or without =VALUE, \
                 principal_point, tangential, aspect_ratio, radial=N"
                    .to_owned(),
            ..plain(
                "fixed",
                ParameterValue::StringArray(Vec::new()),
                "Camera parameters that are not estimated: without a value a distortion coefficient stays 0 and the \
                 principal point the middle of the frame.",
            )
        },
        Declaration {
            range: Range::Integers(3, 1000),
            ..plain(
                "min_views",
                ParameterValue::Integer(10),
                "Views that must have been kept before ~/calibrate solves.",
            )
        },
        Declaration {
            range: Range::Integers(3, 1000),
            constraints: "not less than min_views".to_owned(),
            ..plain(
                "max_views",
                ParameterValue::Integer(60),
                "Views kept at most. Then a view that tells more about the camera replaces the one that tells least.",
            )
        },
        Declaration {
            range: Range::Doubles(0.0, 1000.0),
            ..plain(
                "target_px",
                ParameterValue::Double(0.1),
                "The views are enough where the projection uncertainty at infinity is below this everywhere in the frame, px; 0: as \
                 soon as there are min_views that cover the frame.",
            )
        },
        plain(
            "auto_calibrate",
            ParameterValue::Boolean(false),
            "Calibrate without being asked as soon as the views are enough (see target_px), and again with every max_views / 4 more.",
        ),
        Declaration {
            constraints: "not empty".to_owned(),
            ..plain(
                "camera_name",
                text("camera"),
                "Name of the camera in the file that ~/save writes; the camera driver compares it with its own.",
            )
        },
        plain(
            "save_dir",
            text(""),
            "Folder in which ~/save writes camera_info.yaml; it is made where it does not exist. Empty: \
             $ROS_HOME/ringcal/CAMERA_NAME, where ROS_HOME is ~/.ros unless set.",
        ),
        Declaration {
            range: Range::Doubles(0.01, 1.0),
            ..plain(
                "debug_scale",
                ParameterValue::Double(0.5),
                "Size of the uncompressed pictures ~/debug_image and ~/enhanced_image relative to the frame.",
            )
        },
        Declaration {
            range: Range::Integers(1, 100),
            ..plain(
                "jpeg_quality",
                ParameterValue::Integer(80),
                "Quality of ~/debug_image/compressed and ~/enhanced_image/compressed.",
            )
        },
        Declaration {
            range: Range::Doubles(0.0, 1000.0),
            ..plain(
                "max_motion_px",
                ParameterValue::Double(2.0),
                "A frame is kept only where no ring moved by more than this since the frame before, px; 0 switches \
                 the rule off.",
            )
        },
    ]
}
