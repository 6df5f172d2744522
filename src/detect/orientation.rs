//! Which ring is row 0, column 0: the quarter turns of a lattice and the rule that picks one.

use super::labelling::{Label, extent};
use crate::camera::homography::apply;
use nalgebra::{Matrix3, Point2};

/// A turn of the labels by a number of quarters, then a shift: the numbering of the board. Handedness is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Numbering {
    quarters: u8,
    first: Label,
}

impl Numbering {
    /// Board column and row of a lattice label; negative or too large where it lies off the board.
    pub(super) fn of(self, label: Label) -> Label {
        let (column, row) = turn(label, self.quarters);
        (column - self.first.0, row - self.first.1)
    }

    /// Lattice label of a board column and row.
    pub(super) fn label(self, (column, row): Label) -> Label {
        turn(
            (column + self.first.0, row + self.first.1),
            4 - self.quarters,
        )
    }

    /// The angle of the direction of increasing column at the board's middle, rad from image +x towards +y.
    fn column_angle(self, homography: &Matrix3<f64>, columns: u16, rows: u16) -> Option<f64> {
        let plane = |column: f64, row: f64| {
            let first = self.label((0, 0));
            let along = self.label((1, 0));
            let down = self.label((0, 1));
            let mix = |o: i32, a: i32, d: i32| {
                f64::from(o) + column * f64::from(a - o) + row * f64::from(d - o)
            };
            apply(
                homography,
                Point2::new(mix(first.0, along.0, down.0), mix(first.1, along.1, down.1)),
            )
        };
        let (column, row) = (0.5 * f64::from(columns - 1), 0.5 * f64::from(rows - 1));
        let step = plane(column + 1e-3, row)? - plane(column - 1e-3, row)?;
        Some(step.y.atan2(step.x))
    }
}

/// Fraction of a lattice's labels that must be on the board; the others may be blots beside it.
const NEARLY_ALL: f64 = 0.9;

/// Angles that differ by less are one to the orientation rule, rad.
const SLIGHTLY: f64 = 0.1;

/// One quarter turn makes the old row direction the new column direction.
fn turn(label: Label, quarters: u8) -> Label {
    (0..quarters % 4).fold(label, |(column, row), _| (row, -column))
}

/// How far outside the half-open range of the orientation rule the columns run: their angle, 0 inside.
fn outside(
    numbering: &Numbering,
    homography: &Matrix3<f64>,
    rows: u16,
    columns: u16,
) -> Option<f64> {
    let half_range = if rows == columns {
        std::f64::consts::FRAC_PI_4
    } else {
        std::f64::consts::FRAC_PI_2
    };
    let angle = numbering.column_angle(homography, columns, rows)?;
    let inside = angle > -half_range && angle <= half_range;
    Some(if inside { 0.0 } else { angle.abs() })
}

/// The numbering that covers most of the lattice; of those that cover equally much, the one whose columns run as the
/// orientation rule says: within (-90, 90] degrees of image +x for rows != columns, within (-45, 45] for square boards.
pub(super) fn choose(
    labels: &[Label],
    homography: &Matrix3<f64>,
    rows: u16,
    columns: u16,
) -> Option<Numbering> {
    (0..4)
        .filter_map(|quarters| {
            let (numbering, covered) = best_window(labels, quarters, rows, columns)?;
            let outside = outside(&numbering, homography, rows, columns)?;
            Some((covered, outside, numbering))
        })
        .min_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)))
        .map(|(_, _, numbering)| numbering)
}

/// All numberings that put nearly all labels on the board, with columns that run as the orientation rule says: where rows or columns do not
/// show, there are several.
pub(super) fn upright(
    labels: &[Label],
    homography: &Matrix3<f64>,
    rows: u16,
    columns: u16,
) -> Vec<Numbering> {
    let nearly_all = covering(labels, rows, columns);
    let most = nearly_all.iter().map(|way| way.1).max();
    let fitting = nearly_all
        .into_iter()
        .filter(|&(_, covered)| Some(covered) == most);
    let angles: Vec<(f64, Numbering)> = fitting
        .filter_map(|(n, _)| Some((outside(&n, homography, rows, columns)?, n)))
        .collect();
    let least = angles.iter().map(|a| a.0).fold(f64::INFINITY, f64::min);
    // a plane seen in perspective turns a little from one window to the next
    let as_upright = angles.into_iter().filter(|a| a.0 <= least + SLIGHTLY);
    as_upright.map(|(_, numbering)| numbering).collect()
}

/// All numberings that put nearly all labels on the board.
pub(super) fn numberings(labels: &[Label], rows: u16, columns: u16) -> Vec<Numbering> {
    let nearly_all = covering(labels, rows, columns).into_iter();
    nearly_all.map(|(numbering, _)| numbering).collect()
}

/// The numberings that put nearly all labels on the board, and how many those are.
fn covering(labels: &[Label], rows: u16, columns: u16) -> Vec<(Numbering, usize)> {
    let least = (NEARLY_ALL * labels.len() as f64).ceil() as usize;
    let turns = (0..4).flat_map(|quarters| windows(labels, quarters, rows, columns));
    turns.filter(|&(_, covered)| covered >= least).collect()
}

/// The shift that puts most labels on the board, the smallest on ties, and how many those are.
fn best_window(
    labels: &[Label],
    quarters: u8,
    rows: u16,
    columns: u16,
) -> Option<(Numbering, usize)> {
    windows(labels, quarters, rows, columns)
        .into_iter()
        .max_by(|a, b| a.1.cmp(&b.1).then_with(|| b.0.first.cmp(&a.0.first)))
}

/// Every shift of a turned board along the lattice, and how many labels it puts on the board.
fn windows(labels: &[Label], quarters: u8, rows: u16, columns: u16) -> Vec<(Numbering, usize)> {
    let turned: Vec<Label> = labels.iter().map(|&l| turn(l, quarters)).collect();
    if turned.is_empty() {
        return Vec::new();
    }
    let ((left, right), (top, bottom)) = extent(turned.iter().copied());
    let (columns, rows) = (i32::from(columns), i32::from(rows));
    let shifts = |first: i32, last: i32, size: i32| {
        let other = last - size + 1;
        first.min(other)..=first.max(other)
    };
    let covered = |first: Label| {
        turned
            .iter()
            .filter(|l| {
                (0..columns).contains(&(l.0 - first.0)) && (0..rows).contains(&(l.1 - first.1))
            })
            .count()
    };
    shifts(top, bottom, rows)
        .flat_map(|row| shifts(left, right, columns).map(move |column| (column, row)))
        .map(|first| (Numbering { quarters, first }, covered(first)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation2;

    fn labels(columns: i32, rows: i32) -> Vec<Label> {
        (0..rows)
            .flat_map(|r| (0..columns).map(move |c| (c + 5, r - 3)))
            .collect()
    }

    fn turned_by(degrees: f64) -> Matrix3<f64> {
        let r = Rotation2::new(degrees.to_radians()).to_homogeneous();
        Matrix3::new(20.0, 0.0, 300.0, 0.0, 20.0, 300.0, 0.0, 0.0, 1.0) * r
    }

    fn column_degrees(degrees: f64, columns: u16, rows: u16) -> f64 {
        let all = labels(i32::from(columns), i32::from(rows));
        let h = turned_by(degrees);
        let n = choose(&all, &h, rows, columns).unwrap();
        assert!(all.iter().all(|&l| {
            let (c, r) = n.of(l);
            (0..i32::from(columns)).contains(&c)
                && (0..i32::from(rows)).contains(&r)
                && n.label((c, r)) == l
        }));
        n.column_angle(&h, columns, rows).unwrap().to_degrees()
    }

    #[test]
    fn square_boards_keep_columns_within_45_degrees_of_x() {
        for degrees in [-170.0, -100.0, -44.0, 0.0, 44.0, 46.0, 91.0, 179.0] {
            let found = column_degrees(degrees, 7, 7);
            assert!(found > -45.0 && found <= 45.0, "{degrees} {found}");
        }
    }

    #[test]
    fn oblong_boards_keep_columns_within_90_degrees_of_x() {
        for degrees in [-170.0_f64, -91.0, -89.0, 0.0, 60.0, 89.0, 91.0, 179.0] {
            let found = column_degrees(degrees, 5, 4);
            assert!(found > -90.0 && found <= 90.0, "{degrees} {found}");
            let turned = (found - degrees).rem_euclid(180.0);
            assert!(turned.min(180.0 - turned) < 1e-3, "{degrees} {found}");
        }
    }

    #[test]
    fn the_window_with_most_rings_wins() {
        let mut all = labels(5, 4);
        all.push((20, 0));
        all.retain(|l| *l != (6, -2));
        let n = choose(&all, &turned_by(3.0), 4, 5).unwrap();
        assert_eq!(n.of((5, -3)), (0, 0));
        assert_eq!(n.of((9, 0)), (4, 3));
    }

    #[test]
    fn a_board_without_one_of_its_outermost_columns_can_be_laid_in_several_ways() {
        let seen = labels(4, 4);
        let ways = upright(&seen, &turned_by(3.0), 4, 5);
        let first: Vec<Label> = ways.iter().map(|way| way.of((5, -3))).collect();
        // and as many ways with its columns downwards: four rows show as well as four columns
        assert_eq!(first.len(), 4);
        assert!(first.contains(&(0, 0)) && first.contains(&(1, 0)));
        assert_eq!(upright(&labels(5, 4), &turned_by(3.0), 4, 5).len(), 1);
    }
}
