use super::*;
use crate::calibrate::synthetic::wide;
use crate::camera::{Camera, Distortion, Intrinsics, LensModel};
use crate::formats::RegionOfInterest;
use proptest::prelude::*;

fn any_number() -> impl Strategy<Value = f64> {
    prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO
}

fn any_camera() -> impl Strategy<Value = Camera> {
    let pinhole = (
        prop::array::uniform2(1e-3..1e6_f64),
        prop::array::uniform2(any_number()),
    );
    let lens = (
        prop::sample::select(LensModel::ALL.to_vec()),
        prop::array::uniform8(any_number()),
    );
    let size = prop::array::uniform2(1..100_000_u32);
    (size, pinhole, lens).prop_map(|([width, height], (f, c), (model, values))| Camera {
        width,
        height,
        intrinsics: Intrinsics {
            fx: f[0],
            fy: f[1],
            cx: c[0],
            cy: c[1],
        },
        distortion: Distortion::new(model, &values[..model.coefficient_count()]).unwrap(),
    })
}

/// Whether a format has a place for the lens: the table of docs/formats.md.
fn holds(format: CameraFormat, lens: &Distortion) -> bool {
    let fisheye = lens.model() == LensModel::Equidistant;
    match format {
        CameraFormat::CameraInfo | CameraFormat::OpenCv => true,
        CameraFormat::Ost | CameraFormat::Mrcal => !fisheye,
        CameraFormat::Kalibr => lens.coefficients()[4..].iter().all(|k| *k == 0.0),
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_to_the_last_bit_or_refused(
        camera in any_camera(),
        name in "[^\\[\\]\\p{C}]*",
        rectification in prop::array::uniform9(any_number()),
    ) {
        for format in CameraFormat::ALL {
            let mut info = CameraInfo::new(name.as_str(), camera);
            if format == CameraFormat::Ost {
                info.rectification = rectification;
            }
            let written = format.write(&info);
            prop_assert_eq!(written.is_ok(), holds(format, &camera.distortion), "{}", format);
            let Ok(text) = written else { continue };
            let read = read_camera(&text, None);
            if format == CameraFormat::Mrcal {
                prop_assert_eq!(format.leaves_out(&info).len(), usize::from(!name.is_empty()));
                info.camera_name.clear();
            }
            if format == CameraFormat::Kalibr && camera.model() == LensModel::RationalPolynomial {
                // the four coefficients are the same lens by a shorter name
                let five = &camera.distortion.coefficients()[..5];
                info.camera.distortion = Distortion::new(LensModel::PlumbBob, five).unwrap();
            }
            prop_assert_eq!(read, Ok(info), "{}\n{}", format, text);
        }
    }

    /// A lens without k3 is all that Kalibr needs.
    #[test]
    fn kalibr_holds_four_coefficients(camera in any_camera()) {
        let mut values = camera.distortion.coefficients();
        values[4..].fill(0.0);
        let distortion = Distortion::new(camera.model(), &values).unwrap();
        let text = CameraFormat::Kalibr.write(&CameraInfo::new("a", Camera { distortion, ..camera })).unwrap();
        let read = read_camera(&text, None).unwrap().camera;
        prop_assert_eq!(read.intrinsics, camera.intrinsics);
        prop_assert_eq!(&read.distortion.coefficients()[..4], &values[..4]);
    }

    #[test]
    fn a_damaged_file_is_refused_or_read_but_never_a_panic(
        format in prop::sample::select(CameraFormat::ALL.to_vec()),
        at in any::<prop::sample::Index>(),
        with in "[\\[\\]{}:,\"'\n #0-9a.\\-]{0,3}",
        without in 0..30_usize,
    ) {
        let lens = [-0.3, 0.09, 0.0008, -0.0012, 0.0];
        let distortion = Distortion::new(LensModel::PlumbBob, &lens).unwrap();
        let text = format.write(&CameraInfo::new("front", Camera { distortion, ..wide() })).unwrap();
        let (from, to) = (at.index(text.len()), text.len().min(at.index(text.len()) + without));
        let _ = read_camera(&(text[..from].to_owned() + &with + &text[to..]), None);
    }
}

#[test]
fn what_a_format_leaves_out_is_told() {
    let mut info = CameraInfo::new("left", wide());
    for format in CameraFormat::ALL {
        let wanted: &[_] = match format {
            CameraFormat::Mrcal => &["the camera's name"],
            _ => &[],
        };
        assert_eq!(format.leaves_out(&info), wanted);
    }
    info.projection[3] = -0.1;
    info.roi = Some(RegionOfInterest {
        x_offset: 0,
        y_offset: 0,
        height: 2,
        width: 2,
        do_rectify: false,
    });
    assert_eq!(
        CameraFormat::Ost.leaves_out(&info),
        ["the region of interest"]
    );
    assert_eq!(
        CameraFormat::OpenCv.leaves_out(&info),
        ["the projection matrix", "the region of interest"]
    );
    assert!(CameraFormat::CameraInfo.leaves_out(&info).is_empty());
}

#[test]
fn nothing_that_is_not_finite_is_written() {
    let mut camera = wide();
    camera.intrinsics.fx = f64::NAN;
    for format in CameraFormat::ALL {
        let said = format.write(&CameraInfo::new("a", camera)).unwrap_err();
        assert_eq!(said.to_string(), "the camera holds NaN, no file does");
    }
}

#[test]
fn names_of_formats_and_files() {
    for format in CameraFormat::ALL {
        assert_eq!(format.name().parse(), Ok(format));
        let path = Path::new("a/b").join(format.file_name());
        assert_eq!(CameraFormat::of_path(&path), Some(format));
    }
    assert_eq!(CameraFormat::of_path(Path::new("calibration.json")), None);
    assert_eq!(CameraFormat::of_path(Path::new("-")), None);
    assert!(
        "yaml"
            .parse::<CameraFormat>()
            .unwrap_err()
            .to_string()
            .contains("kalibr")
    );
}

#[test]
fn other_texts_are_refused_with_what_was_expected() {
    let refused = |text: &str| read_camera(text, None).unwrap_err().to_string();
    assert!(refused("").contains("not a camera_info file"));
    assert!(refused("rows: 7\n").contains("image_width"));
    assert!(refused("<?xml version=\"1.0\"?>\n<opencv_storage>").contains("not as XML"));
    assert!(refused("{\"parameters\": 1}").contains("not a calibration.json"));
    assert!(refused("cam0: 1").contains("not a Kalibr camchain"));
    let text = CameraFormat::CameraInfo
        .write(&CameraInfo::new("left", wide()))
        .unwrap();
    assert!(
        read_camera(
            &format!("\u{feff}{}", text.replace('\n', "\r\n")),
            Some("left")
        )
        .is_ok()
    );
    let said = read_camera(&text, Some("right")).unwrap_err().to_string();
    assert!(said.contains("no camera \"right\", but left"), "{said}");
}
