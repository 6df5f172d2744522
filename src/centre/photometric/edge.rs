//! Draws a circle whose blurred edge is known in closed form: every pixel by itself, as many at once as the machine's vectors hold.

use super::coverage::{COVERAGE_PARAMETERS, Plane};
use super::feet::{Circle, Foot};
use super::real::{Floats, Real, columns};
use super::shape::SHAPE_PARAMETERS;
use super::window::Grid;
use pulp::{Arch, Simd, WithSimd};

/// The first way to the edge is longer than the distance where the edge bends; by no more than this factor where it is in reach.
const LONGER: f32 = 1.5;

/// What a pixel sees of a blurred edge.
#[derive(Clone, Copy)]
pub(super) struct Seen<T> {
    /// Coverage.
    pub(super) value: T,
    /// How fast it falls with the distance, by pixel of the grid.
    pub(super) slope: T,
    /// Change by the blur's size in pixels of the grid.
    pub(super) growth: T,
    /// How far from the foot the two points are that stand for the arc it sees; the foot alone does where there are none.
    pub(super) aside: Option<T>,
}

/// A circle's edge under one kind of blur.
pub(super) trait BlurredEdge {
    /// The circle.
    fn circle(&self) -> &Circle;

    /// Pixels that are farther from the edge see one side only, pixels of the grid.
    fn reach(&self) -> f32;

    /// Coverage of pixels.
    fn value<T: Real>(&self, foot: &Foot<T>) -> T;

    /// Coverage of pixels, and how it changes.
    fn see<T: Real>(&self, foot: &Foot<T>) -> Seen<T>;
}

/// Adds the coverage by a circle to the first of the planes and, with a contrast, its changes to the others.
pub(super) fn draw<E: BlurredEdge>(
    edge: &E,
    grid: &Grid,
    (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
    contrast: Option<f32>,
) {
    Arch::new().dispatch(Draw {
        edge,
        grid,
        values,
        changes,
        contrast,
    });
}

struct Draw<'a, E> {
    edge: &'a E,
    grid: &'a Grid,
    values: &'a mut Plane,
    changes: &'a mut [Plane; COVERAGE_PARAMETERS],
    contrast: Option<f32>,
}

impl<E: BlurredEdge> WithSimd for Draw<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let stride = self.grid.stride();
        let (circle, reach) = (self.edge.circle(), self.edge.reach());
        let beyond = (LONGER * reach).powi(2);
        for row in circle.rows(f64::from(reach)) {
            let span = row * stride..(row + 1) * stride;
            let values = S::as_mut_simd_f32s(&mut self.values[span.clone()]).0;
            let changes = self.changes.each_mut().map(|plane| {
                let row = plane.get_mut(span.clone()).unwrap_or_default();
                S::as_mut_simd_f32s(row).0
            });
            for (v, out) in values.iter_mut().enumerate() {
                let way = circle.way(circle.about_centre(columns(simd, v), row));
                let sum = Floats::new(simd, *out);
                let way_square = way.signed_square();
                if way_square.smallest() > beyond {
                    continue;
                }
                if way_square.largest() < -beyond {
                    *out = (sum + 1.0).values;
                    continue;
                }
                let foot = circle.foot(&way);
                let Some(contrast) = self.contrast else {
                    *out = (sum + self.edge.value(&foot)).values;
                    continue;
                };
                let seen = self.edge.see(&foot);
                *out = (sum + seen.value).values;
                let slope = seen.slope * contrast;
                let moved = match seen.aside {
                    Some(aside) => circle.moved_along(&foot, slope, aside),
                    None => circle.moved(&foot, slope),
                };
                for k in 0..SHAPE_PARAMETERS {
                    let plane = &mut changes[k][v];
                    *plane = (Floats::new(simd, *plane) + moved[k]).values;
                }
                let by_size = &mut changes[SHAPE_PARAMETERS][v];
                *by_size = (Floats::new(simd, *by_size) + seen.growth * contrast).values;
            }
        }
    }
}
