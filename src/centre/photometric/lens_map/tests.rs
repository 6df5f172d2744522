use super::super::plane::PlaneView;
use super::*;
use crate::camera::Equidistant;
use nalgebra::Point3;

fn anchors(lens: [f64; MOST_LENS]) -> (LensMap, Vec<Anchor>) {
    let [k1, k2, p1, p2, k3] = lens;
    let mut camera = blank(1280, 960);
    camera.distortion = PlumbBob { k1, k2, p1, p2, k3 }.into();
    let map = LensMap {
        homography: Matrix3::new(2.62, 0.11, -0.57, -0.075, 2.37, -0.41, 0.9, -0.6, 1.0),
        camera,
        fan: Fan::default(),
        free: MOST_LENS,
    };
    let anchors = (0..49)
        .map(|i| {
            let plane_m = Point2::new(f64::from(i % 7) * 0.05, f64::from(i / 7) * 0.05);
            Anchor {
                plane_m,
                at: map.place(plane_m).unwrap(),
                variance: 1e-4,
            }
        })
        .collect();
    (map, anchors)
}

#[test]
fn a_lens_is_found_again_from_the_centres_it_made() {
    let (truth, anchors) = anchors([-0.11, 0.03, 0.0006, -0.0004, 0.0]);
    let found = LensMap::through(&anchors, &blank(1280, 960)).unwrap();
    for anchor in &anchors {
        assert!((found.map.place(anchor.plane_m).unwrap() - anchor.at).norm() < 1e-3);
        let (a, b) = (
            truth.ring(anchor.plane_m, 0.015).unwrap(),
            found.map.ring(anchor.plane_m, 0.015).unwrap(),
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
    let anchors: Vec<Anchor> = (0..49)
        .map(|i| Point2::new(f64::from(i % 7) * 0.05, f64::from(i / 7) * 0.05))
        .map(|plane_m| Anchor {
            plane_m,
            at: see(plane_m).unwrap(),
            variance: 1e-4,
        })
        .collect();
    let found = LensMap::through(&anchors, &blank(1280, 960)).unwrap();
    for anchor in &anchors {
        let true_shape = shape_under(|d| see(anchor.plane_m + d * 0.015)).unwrap();
        let shape = found.map.ring(anchor.plane_m, 0.015).unwrap();
        let off = (shape.perspective - true_shape.perspective).norm();
        // a polynomial alone is off by 1e-4
        assert!(off < 5e-6, "{off}");
    }
}

#[test]
fn without_a_lens_a_ring_is_that_of_the_plane() {
    let (map, anchors) = anchors([0.0; MOST_LENS]);
    let pairs: Vec<_> = anchors.iter().map(|a| (a.plane_m, a.at)).collect();
    let view = PlaneView::through(&pairs).unwrap();
    for anchor in &anchors {
        let bent = map.ring(anchor.plane_m, 0.01).unwrap();
        let flat = view.perspective(&anchor.at);
        assert!((bent.centre - anchor.at).norm() < 1e-9);
        assert!((bent.perspective - flat).norm() < 1e-3 * flat.norm());
    }
}
