//! What the options hold, and where they say to start.

use super::*;

fn views_of(camera: &Camera) -> Vec<View> {
    views(camera, &board(), &poses(camera, &board()), 0.05, 2)
}

#[test]
fn a_guess_of_another_frame_size_is_refused_with_both_sizes() {
    let camera = ordinary();
    let options = CalibrateOptions {
        guess: Some(Camera {
            width: 320,
            height: 240,
            ..camera
        }),
        ..CalibrateOptions::default()
    };
    let error = calibrate(&board(), &views_of(&camera), &options).unwrap_err();
    let size = (camera.width, camera.height);
    assert_eq!(
        error,
        CalibrateError::GuessSize {
            guess: (320, 240),
            frames: size
        }
    );
    let said = error.to_string();
    assert!(said.contains("320 x 240") && said.contains(&format!("{} x {}", size.0, size.1)));
}

#[test]
fn with_the_aspect_ratio_either_focal_length_holds_both() {
    let camera = ordinary();
    let views = views_of(&camera);
    for entries in [["aspect_ratio", "fy=1201"], ["fx=1201", "aspect_ratio"]] {
        let mut options = CalibrateOptions {
            fixed: Fixed::from_entries(entries).unwrap(),
            ..CalibrateOptions::default()
        };
        let found = calibrate(&board(), &views, &options).unwrap();
        let k = found.camera.intrinsics;
        assert_eq!((k.fx, k.fy), (1201.0, 1201.0), "{entries:?}");
        assert_eq!(found.fixed, ["fx", "fy"]);
        assert_eq!((found.std(0), found.std(1)), (0.0, 0.0));

        let mut guess = camera;
        (guess.intrinsics.fx, guess.intrinsics.fy) = (1000.0, 1002.0);
        options.guess = Some(guess);
        let k = calibrate(&board(), &views, &options)
            .unwrap()
            .camera
            .intrinsics;
        assert!((k.fy / k.fx - 1.002).abs() < 1e-12, "{entries:?}: {k:?}");
        assert!(k.fx == 1201.0 || k.fy == 1201.0);
    }
}
