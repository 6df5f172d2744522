//! The two photographs of a hand-held board beside the project: found whole, in order, whichever way they are turned.

use image::{DynamicImage, imageops};
use nalgebra::Point2;
use ringcal::board::{Board, Polarity};
use ringcal::detect::{DetectOptions, Detection, Detector};
use ringcal::frame::{Frame, Plane};
use std::path::Path;

const PHOTOGRAPHS: [&str; 2] = ["rings_4x5_a.png", "rings_4x5_b.png"];

/// `None` (and a word of it) where the photographs are not beside the checkout.
fn photograph(name: &str) -> Option<DynamicImage> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real");
    let path = folder.join(name);
    if !path.exists() {
        eprintln!("skipped: no photograph {name} beside the project");
        return None;
    }
    Some(image::open(path).unwrap())
}

fn detect(picture: &DynamicImage) -> Detection {
    let grey = picture.to_luma8();
    let (width, height) = (grey.width() as usize, grey.height() as usize);
    let frame = Frame::from_u8(
        Plane::from_vec(width, height, grey.into_raw()).unwrap(),
        "photograph",
    );
    // about 0.53 and 2.9 outer radii: the board was made by hand and never measured
    let board = Board::new(4, 5, 2.9, 0.53, 1.0, Polarity::DarkOnLight).unwrap();
    Detector::new(board, DetectOptions::default())
        .detect(&frame)
        .unwrap()
}

fn residual_rms(detection: &Detection) -> f64 {
    let sum: f64 = detection
        .rings
        .iter()
        .map(|r| {
            let plane = Point2::new(2.9 * f64::from(r.column), 2.9 * f64::from(r.row));
            let p = detection.homography * plane.to_homogeneous();
            (Point2::new(p.x / p.z, p.y / p.z) - r.centre.point).norm_squared()
        })
        .sum();
    (sum / detection.rings.len() as f64).sqrt()
}

#[test]
fn twenty_rings_on_one_plane_in_order_however_turned() {
    for name in PHOTOGRAPHS {
        let Some(upright) = photograph(name) else {
            return;
        };
        let turns = [
            upright.clone(),
            upright.rotate90(),
            upright.rotate180(),
            upright.rotate270(),
        ];
        for (quarters, turned) in turns.iter().enumerate() {
            let detection = detect(turned);
            assert_eq!(
                detection.rings.len(),
                20,
                "{name} turned by {quarters} quarters"
            );
            let rms = residual_rms(&detection);
            eprintln!(
                "{name} turned by {quarters} quarters: {rms:.3} px rms to the best homography"
            );
            assert!(rms < 0.5, "{name}: {rms}");
            // the directions of increasing column and row at the board's middle
            let image = |column: f64, row: f64| {
                let p =
                    detection.homography * Point2::new(2.9 * column, 2.9 * row).to_homogeneous();
                Point2::new(p.x / p.z, p.y / p.z)
            };
            let column = image(2.01, 1.5) - image(1.99, 1.5);
            let row = image(2.0, 1.51) - image(2.0, 1.49);
            assert!(column.perp(&row) > 0.0, "mirrored");
            let degrees = column.y.atan2(column.x).to_degrees();
            assert!(
                degrees > -90.0 && degrees <= 90.0,
                "columns run at {degrees} degrees"
            );
        }
    }
}

#[test]
fn blurred_photographs_are_found_too() {
    for name in PHOTOGRAPHS {
        let Some(picture) = photograph(name) else {
            return;
        };
        // at 8 px, the smallest rings are hardly twice as large as their blur
        for (sigma, most_px) in [
            (2.0_f32, 0.6),
            (4.0, 0.6),
            (6.0, 1.0),
            (7.0, 1.0),
            (8.0, 1.0),
        ] {
            let blurred = DynamicImage::ImageLuma8(imageops::blur(&picture.to_luma8(), sigma));
            let detection = detect(&blurred);
            assert_eq!(detection.rings.len(), 20, "{name} blurred by {sigma} px");
            let rms = residual_rms(&detection);
            eprintln!("{name} blurred by {sigma} px: {rms:.3} px rms");
            assert!(rms < most_px, "{name} blurred by {sigma} px: {rms}");
        }
    }
}
