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
