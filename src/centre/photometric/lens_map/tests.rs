use super::super::plane::PlaneView;
use super::super::sighting::Sighting;
use super::super::through::Through;
use super::*;
use crate::camera::Equidistant;
use nalgebra::Point3;

const RADIUS_M: f64 = 0.015;

/// A ring whose centre is exact to a hundredth of a pixel, and whose own perspective says as good as nothing.
fn sighting(plane_m: Point2<f64>, centre: Point2<f64>) -> Sighting {
    Sighting {
        plane_m,
        centre,
        perspective: Vector2::zeros(),
        gain: Matrix2::zeros(),
        given: Matrix2::identity() * 1e-4,
        of_perspective: Matrix2::identity(),
    }
}

fn sightings(lens: [f64; 5]) -> (LensMap, Vec<Sighting>) {
    let [k1, k2, p1, p2, k3] = lens;
    let mut camera = blank(1280, 960);
    camera.distortion = PlumbBob { k1, k2, p1, p2, k3 }.into();
    let map = LensMap {
        homography: Matrix3::new(2.62, 0.11, -0.57, -0.075, 2.37, -0.41, 0.9, -0.6, 1.0),
        camera,
        fan: Fan::default(),
        free: MOST_LENS,
    };
    let rings = (0..49)
        .map(|i| {
            let plane_m = Point2::new(f64::from(i % 7) * 0.05, f64::from(i / 7) * 0.05);
            sighting(plane_m, map.place(plane_m).unwrap())
        })
        .collect();
    (map, rings)
}

#[test]
fn a_lens_is_found_again_from_the_centres_it_made() {
    let (truth, rings) = sightings([-0.11, 0.03, 0.0006, -0.0004, 0.0]);
    let found = Through::rings(&rings, RADIUS_M, &blank(1280, 960)).unwrap();
    for ring in &rings {
        assert!((found.map.place(ring.plane_m).unwrap() - ring.centre).norm() < 1e-3);
        let (a, b) = (
            truth.ring(ring.plane_m, RADIUS_M).unwrap(),
            found.map.ring(ring.plane_m, RADIUS_M).unwrap(),
        );
        assert!((a.perspective - b.perspective).norm() < 1e-7);
    }
}

#[test]
fn a_fisheye_is_found_from_the_centres_it_made() {
    let mut camera = blank(1280, 960);
    camera.intrinsics.fx = 500.0;
    camera.intrinsics.fy = 500.0;
    let k = [0.02, -0.005, 0.001, -0.0005];
    camera.distortion = Equidistant { k }.into();
    let rotation = nalgebra::Rotation3::from_euler_angles(0.4, -0.5, 0.1);
    let see = |at: Point2<f64>| {
        let point = rotation * nalgebra::Vector3::new(at.x - 0.15, at.y - 0.15, 0.0);
        camera.project(&Point3::from(
            point + nalgebra::Vector3::new(0.05, 0.03, 0.2),
        ))
    };
    let rings: Vec<Sighting> = (0..49)
        .map(|i| Point2::new(f64::from(i % 7) * 0.05, f64::from(i / 7) * 0.05))
        .map(|plane_m| sighting(plane_m, see(plane_m).unwrap()))
        .collect();
    let found = Through::rings(&rings, RADIUS_M, &blank(1280, 960)).unwrap();
    for ring in &rings {
        let true_shape = shape_under(|d| see(ring.plane_m + d * RADIUS_M)).unwrap();
        let shape = found.map.ring(ring.plane_m, RADIUS_M).unwrap();
        let off = (shape.perspective - true_shape.perspective).norm();
        // a polynomial alone is off by 1e-4
        assert!(off < 5e-6, "{off}");
    }
}

#[test]
fn without_a_lens_a_ring_is_that_of_the_plane() {
    let (map, rings) = sightings([0.0; 5]);
    let pairs: Vec<_> = rings.iter().map(|a| (a.plane_m, a.centre)).collect();
    let view = PlaneView::through(&pairs).unwrap();
    for ring in &rings {
        let bent = map.ring(ring.plane_m, 0.01).unwrap();
        let flat = view.perspective(&ring.centre);
        assert!((bent.centre - ring.centre).norm() < 1e-9);
        assert!((bent.perspective - flat).norm() < 1e-3 * flat.norm());
    }
}

#[test]
fn the_axis_of_the_lens_and_the_shape_of_the_pixels_are_found() {
    let mut camera = blank(1280, 960);
    (camera.intrinsics.cx, camera.intrinsics.cy) = (651.0, 468.0);
    camera.intrinsics.fy = 1.004 * camera.intrinsics.fx;
    let (mut truth, _) = sightings([-0.09, 0.016, 0.0005, 0.0002, 0.0]);
    camera.distortion = truth.camera.distortion;
    truth.camera = camera;
    // a few large rings, as their fits see them
    let rings: Vec<Sighting> = (0..20)
        .map(|i| Point2::new(f64::from(i % 5) * 0.06, f64::from(i / 5) * 0.06))
        .map(|plane_m| Sighting {
            given: Matrix2::identity() * 1e-6,
            ..sighting(plane_m, truth.place(plane_m).unwrap())
        })
        .collect();
    let found = Through::rings(&rings, 0.02, &blank(1280, 960)).unwrap();
    for (ring, said) in rings.iter().zip(&found.perspectives) {
        let shape = truth.ring(ring.plane_m, 0.02).unwrap();
        let off = (said.perspective - shape.perspective).norm();
        // with the axis in the middle of the frame it is off by 20 times that in the corners
        assert!(off < 1e-7, "{off}");
    }
}

#[test]
fn derivatives_agree_with_finite_differences() {
    let (mut map, rings) = sightings([-0.09, 0.03, 0.0005, 0.0002, 0.001]);
    map.camera.intrinsics.fy = 1.004 * map.camera.intrinsics.fx;
    map.fan = Fan(0.8);
    for ring in rings.iter().step_by(8) {
        let rows = map.derivatives(ring.plane_m).unwrap();
        for k in 0..map.parameters() {
            let mut step = SVector::zeros();
            step[k] = 1e-6;
            let there = map.moved(&step).place(ring.plane_m).unwrap();
            let back = map.moved(&-step).place(ring.plane_m).unwrap();
            let by = (there - back) / 2e-6;
            assert!(
                (by - rows.column(k)).norm() < 1e-4 * (1.0 + by.norm()),
                "{k}"
            );
        }
    }
}
