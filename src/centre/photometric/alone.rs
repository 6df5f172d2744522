//! What one ring of a crowded board says by its own window: the equations of its parameters, and how what its neighbours show there changes
//! them (`crowd` has the symbols).

use super::around::reaches;
use super::coverage::{COVERAGE_PARAMETERS, LANES, Plane};
use super::descent::add_priors;
use super::equations::{diagonal_scales, freeze, scaled_by};
use super::model::{BLUR, Matrix, PARAMETERS, RingModel, SHEET, Vector};
use super::problem::{Normal, Problem, Workspace};
use super::rows::shades;
use super::shape::SHAPE_PARAMETERS;
use super::under::Under;
use super::wall::Wall;
use super::window::Grid;
use nalgebra::SMatrix;

/// Parameters by which a ring shows in its neighbours' windows: shape and blur.
pub(super) const SHOWN: usize = SHAPE_PARAMETERS + 1;
/// Derivatives of one ring times those by another's parameters.
pub(super) type Coupling = SMatrix<f64, PARAMETERS, SHOWN>;
pub(super) type Shown = SMatrix<f64, SHOWN, SHOWN>;

/// Whether the ends of the sheet beside rings are to be found too. They show in no other ring's window, and in their tails what they add is so
/// far from linear that a step would be worth nothing: a fit of the ring finds them better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    Free,
    Held,
}

/// One ring's part as far as it is known from its own window: the B_ij are not yet in the others' units.
pub(super) struct Alone {
    /// A_i^-1.
    pub(super) inverse: Matrix,
    /// g_i.
    pub(super) gradient: Vector,
    /// L_i.
    pub(super) spread: Shown,
    /// How much less its sum of squares would be at its best among the others as they are, in variances of its noise.
    pub(super) wants: f64,
    /// B_ij and j.
    pub(super) couplings: Vec<(usize, Coupling)>,
}

impl Alone {
    /// Of a ring without a fit, which has no say.
    pub(super) fn mute() -> Self {
        Self {
            inverse: Matrix::zeros(),
            gradient: Vector::zeros(),
            spread: Shown::identity(),
            wants: 0.0,
            couplings: Vec::new(),
        }
    }
}

/// What one ring's own window says; `None` where it has no fit.
pub(super) fn alone(
    ratio: f64,
    ring: &Under,
    (own, models, rings): (usize, &[RingModel], &[Under]),
    ends: Ends,
    room: &mut Workspace,
) -> Option<Alone> {
    let (fitted, model) = (ring.fitted.ok()?, models[own]);
    let window = ring.window.as_ref()?;
    let near: Vec<usize> = (0..rings.len())
        .filter(|&j| j != own && reaches(&models[j], &window.grid))
        .filter(|&j| models[j].shape.ellipse(ratio).is_some())
        .collect();
    let (around, shown) = room.neighbours(&window.grid, (&model, ratio), &near, models)?;
    let problem = Problem {
        window,
        ratio,
        around: Some(&around),
        noise: fitted.noise,
    };
    let (normal, mut couplings) = room.couplings(&problem, &model, &shown)?;
    let (mut matrix, mut gradient) = (normal.matrix, normal.gradient);
    let (parameters, wall) = (model.parameters(), Wall::of(&matrix));
    wall.push(&parameters, &mut gradient);
    wall.stiffen(&parameters, &mut matrix);
    add_priors(&mut matrix, model.count());
    if ends == Ends::Held {
        for k in SHEET..model.count() {
            freeze(&mut matrix, k);
            gradient[k] = 0.0;
            couplings
                .iter_mut()
                .for_each(|coupling| coupling.row_mut(k).fill(0.0));
        }
    }
    let inverse = inverse(&matrix)?;
    let shown = inverse.fixed_view::<SHOWN, SHOWN>(0, 0).into_owned();
    let scales = shown.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt());
    let unit = Shown::from_fn(|i, j| shown[(i, j)] / (scales[i] * scales[j]));
    let couplings = near.into_iter().zip(couplings);
    Some(Alone {
        inverse,
        gradient,
        spread: Shown::from_diagonal(&scales) * unit.cholesky()?.l(),
        wants: gradient.dot(&(inverse * gradient)) / (fitted.noise * fitted.noise),
        couplings: couplings
            .filter(|(j, _)| rings[*j].fitted.is_ok())
            .collect(),
    })
}

/// Of a normal matrix, whose units differ by many orders of magnitude.
fn inverse(matrix: &Matrix) -> Option<Matrix> {
    let scales = diagonal_scales::<PARAMETERS>(matrix);
    let inverse = scaled_by(matrix, &scales).cholesky()?.l().try_inverse()?;
    let back = Matrix::from_fn(|i, j| scales[i] * inverse[(j, i)]);
    Some(back * back.transpose())
}

/// What a neighbour shows in a ring's window changes so by its shape and blur (its square, px^2), were it lit like the ring.
struct ShownChanges {
    planes: [Plane; COVERAGE_PARAMETERS],
    by_blur: f64,
}

impl Workspace {
    /// The coverages of a ring's window by its neighbours together, and how what each shows there changes; `None` where one of the shapes is no
    /// ring.
    fn neighbours(
        &mut self,
        grid: &Grid,
        (model, ratio): (&RingModel, f64),
        near: &[usize],
        models: &[RingModel],
    ) -> Option<([Plane; 2], Vec<ShownChanges>)> {
        let size = grid.stride() * grid.height;
        let mut around = [vec![0.0; size], vec![0.0; size]];
        let contrasts = Some(model.contrasts());
        let shown = near.iter().map(|&j| {
            let other = &models[j];
            self.dispatch(
                #[inline(always)]
                |room| {
                    let shape = (&other.shape, &other.blur);
                    room.coverage.fill(grid, shape, ratio, contrasts, None)?;
                    for (sum, circle) in around.iter_mut().zip(&room.coverage.circles) {
                        let pairs = sum.iter_mut().zip(circle);
                        pairs.for_each(|(sum, circle)| *sum += circle);
                    }
                    Some(ShownChanges {
                        planes: std::mem::take(&mut room.coverage.changes),
                        by_blur: other.by_blur(grid),
                    })
                },
            )
        });
        let shown = shown.collect::<Option<Vec<_>>>()?;
        Some((around, shown))
    }

    /// The normal equations at a model, and the products of its derivatives with those by shape and blur of others; `None` where its shape is no
    /// ring.
    fn couplings(
        &mut self,
        problem: &Problem,
        model: &RingModel,
        others: &[ShownChanges],
    ) -> Option<(Normal, Vec<Coupling>)> {
        let grid = &problem.window.grid;
        let mut derivatives = vec![Vec::new(); model.count()];
        let normal = self.normal_and(problem, model, |rows| {
            for (k, all) in derivatives.iter_mut().enumerate() {
                all.extend_from_slice(rows.column(k));
            }
        })?;
        // what is seen of another is shaded like the ring
        let shades: Vec<f32> = (0..grid.height)
            .flat_map(|row| shades(model, grid, row))
            .collect();
        self.dispatch(
            #[inline(always)]
            |_| {
                for derivative in &mut derivatives {
                    let pairs = derivative.iter_mut().zip(&shades);
                    pairs.for_each(|(derivative, shade)| *derivative *= shade);
                }
                let couplings = others.iter().map(|other| {
                    Coupling::from_fn(|a, k| match derivatives.get(a) {
                        Some(own) => {
                            let scale = if k == BLUR { other.by_blur } else { 1.0 };
                            scale * sum_of_products(own, &other.planes[k])
                        }
                        None => 0.0,
                    })
                });
                Some((normal, couplings.collect()))
            },
        )
    }
}

/// Over pixels of padded rows; as many at once as there are lanes.
#[inline(always)]
fn sum_of_products(left: &[f32], right: &[f32]) -> f64 {
    let mut sums = [0.0_f32; LANES];
    let pairs = left.chunks_exact(LANES).zip(right.chunks_exact(LANES));
    for (left, right) in pairs {
        for l in 0..LANES {
            sums[l] += left[l] * right[l];
        }
    }
    f64::from(sums.iter().sum::<f32>())
}
