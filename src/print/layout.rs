//! Where everything goes on the paper.

use super::error::PrintError;
use super::legend::{Line, least_length_mm, legend, scale_sentence};
use super::paper::{MOST_MM, Paper, Stock};
use super::ruler::{depth_mm, overhang_mm};
use super::sheet::Sheet;
use crate::board::{Board, Polarity};

/// Width of the quiet zone over the width of a ring: three blur sigmas at the heaviest blur that is of use
/// ([`super::MOST_BLUR`]).
const QUIET: f64 = 3.0 * super::MOST_BLUR;
/// Between the quiet zone and the rulers, and between it and the legend, mm.
pub(super) const GAP_MM: f64 = 1.0;
pub(super) const LEGEND_GAP_MM: f64 = 2.0;
/// Texts are as large as on A4 up to a field of this width, mm, and grow with its square root beyond.
const SMALL_FIELD_MM: f64 = 200.0;
const MOST_SCALE: f64 = 2.5;
/// The length a ruler should have at least, mm.
pub(super) const RULER_MM: f64 = 100.0;

/// What is to be printed beside the board itself.
#[derive(Debug, Clone, PartialEq)]
pub struct PrintOptions {
    /// Name of the board, printed on the sheet.
    pub name: String,
    /// What is printed on.
    pub stock: Stock,
    /// Width of the quiet zone around the rings, mm; by default 1.2 times the width of a ring.
    pub quiet_mm: Option<f64>,
    /// Border of the paper that no printer reaches, mm.
    pub margin_mm: f64,
}

/// Which side of the field the legend is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    Beside,
}

/// Arranges a board on its paper.
///
/// # Errors
/// [`PrintError`] with the sizes where it does not fit.
pub fn lay_out(board: &Board, options: &PrintOptions) -> Result<Sheet, PrintError> {
    let plan = Plan::new(board, options);
    match &options.stock {
        Stock::Smallest => {
            let [first, larger @ ..] = Paper::usual();
            larger.iter().fold(plan.on_paper(&first), |found, paper| {
                found.or_else(|_| plan.on_paper(paper))
            })
        }
        Stock::Sheet(paper) => plan
            .on_paper(paper)
            .map_err(|refusal| plan.with_hint(refusal)),
        Stock::Roll { width_mm } => plan.on_roll(*width_mm),
    }
}

/// A board with the sizes that follow from it.
pub(super) struct Plan<'a> {
    pub(super) board: Board,
    pub(super) options: &'a PrintOptions,
    pub(super) quiet_mm: f64,
    /// Rings and quiet zone, width and height, mm.
    pub(super) field_mm: [f64; 2],
    /// How much larger than on A4 the texts are.
    pub(super) scale: f64,
}

/// Where things go on a page; `page_mm` is at least `needed_mm` where it fits.
pub(super) struct Arrangement {
    pub(super) side: Side,
    pub(super) page_mm: [f64; 2],
    needed_mm: [f64; 2],
    /// Upper left corner of the field.
    pub(super) field_mm: [f64; 2],
    pub(super) legend: Vec<Line>,
    /// Thickness of the legend, mm.
    pub(super) legend_mm: f64,
}

impl Arrangement {
    fn fits(&self) -> bool {
        self.spare_mm() >= -1e-9
    }

    /// What is left over in the tighter direction, mm.
    fn spare_mm(&self) -> f64 {
        let spare = |axis: usize| self.page_mm[axis] - self.needed_mm[axis];
        spare(0).min(spare(1))
    }
}

impl<'a> Plan<'a> {
    fn new(board: &Board, options: &'a PrintOptions) -> Self {
        let polarity = match board.polarity() {
            Polarity::LightOnDark => Polarity::LightOnDark,
            Polarity::DarkOnLight | Polarity::Auto => Polarity::DarkOnLight,
        };
        let board = board.clone().with_polarity(polarity);
        let ring_m = board.outer_radius_m() - board.inner_radius_m();
        let quiet_mm = options.quiet_mm.unwrap_or(1e3 * QUIET * ring_m);
        let side = |middle_m: f64| 2e3 * (middle_m + board.outer_radius_m()) + 2.0 * quiet_mm;
        let field_mm = board.middle_m().map(side);
        let narrow = field_mm[0].min(field_mm[1]);
        Self {
            scale: (narrow / SMALL_FIELD_MM).sqrt().clamp(1.0, MOST_SCALE),
            board,
            options,
            quiet_mm,
            field_mm,
        }
    }

    /// On a paper, upright or lying: the legend below the rings where it can be, and the way that leaves more room.
    fn on_paper(&self, paper: &Paper) -> Result<Sheet, PrintError> {
        let [width, height] = paper.sides_mm();
        let all = self.arrangements([[width, height], [height, width]]);
        let rank = |a: &&Arrangement| (a.fits(), a.side == Side::Below || !a.fits());
        let better = |a: &&Arrangement, b: &&Arrangement| {
            rank(a)
                .cmp(&rank(b))
                .then(a.spare_mm().total_cmp(&b.spare_mm()))
        };
        match all.iter().max_by(better) {
            Some(best) if best.fits() => Ok(self.sheet(best, paper.name())),
            best => Err(PrintError::DoesNotFit {
                field_mm: self.field_mm,
                needed_mm: best.map_or(self.field_mm, |best| best.needed_mm),
                paper: paper.name().to_owned(),
                paper_mm: best.map_or([width, height], |best| best.page_mm),
                larger: None,
            }),
        }
    }

    /// The refusal with the name of a paper that would do.
    fn with_hint(&self, refusal: PrintError) -> PrintError {
        let holds = |paper: &Paper| self.on_paper(paper).is_ok();
        let hint = Paper::usual()
            .iter()
            .find(|paper| holds(paper))
            .map(|paper| paper.name().to_owned());
        match refusal {
            PrintError::DoesNotFit {
                field_mm,
                needed_mm,
                paper,
                paper_mm,
                ..
            } => PrintError::DoesNotFit {
                field_mm,
                needed_mm,
                paper,
                paper_mm,
                larger: hint,
            },
            other => other,
        }
    }

    /// On a roll, along or across it: the way that takes less of it.
    fn on_roll(&self, roll_mm: f64) -> Result<Sheet, PrintError> {
        let mut all = self.arrangements([[roll_mm, f64::INFINITY], [f64::INFINITY, roll_mm]]);
        let needed_mm = all.iter().map(|a| match a.page_mm[0] == roll_mm {
            true => a.needed_mm[0],
            false => a.needed_mm[1],
        });
        let needed_mm = needed_mm.fold(f64::INFINITY, f64::min);
        all.retain(Arrangement::fits);
        let length = |a: &Arrangement| a.page_mm[0] * a.page_mm[1] / roll_mm;
        let shortest = all.iter().min_by(|a, b| length(a).total_cmp(&length(b)));
        let Some(shortest) = shortest else {
            return Err(PrintError::WiderThanRoll {
                field_mm: self.field_mm,
                needed_mm,
                roll_mm,
            });
        };
        if length(shortest) > MOST_MM {
            return Err(PrintError::TooLong {
                needed_mm: length(shortest),
                most_mm: MOST_MM,
            });
        }
        Ok(self.sheet(
            shortest,
            &format!("roll of {} mm", super::numbers::mm(roll_mm)),
        ))
    }

    fn arrangements(&self, pages_mm: [[f64; 2]; 2]) -> Vec<Arrangement> {
        let both = |page| [self.below(page), self.beside(page)];
        pages_mm.into_iter().flat_map(both).collect()
    }

    /// Depth of a ruler and of the gap to the field.
    pub(super) fn band_mm(&self) -> f64 {
        GAP_MM + depth_mm(self.scale)
    }

    /// The lines above the field, from top to bottom: what the rulers are for, and the corner's name, which is the last one.
    /// Whether both stand in one line.
    pub(super) fn top(&self, ruler_mm: f64, length_mm: f64) -> (Vec<Line>, bool) {
        let corner = Line::corner(self.scale);
        let sentence = Line::body(scale_sentence(ruler_mm), self.scale);
        if corner.length_mm() + corner.em_mm + sentence.length_mm() <= length_mm {
            (vec![sentence, corner], true)
        } else {
            let mut lines = sentence.wrapped(length_mm);
            lines.push(corner);
            (lines, false)
        }
    }

    /// Height of all that is above the field, mm.
    fn top_mm(&self, length_mm: f64) -> f64 {
        let (lines, one_line) = self.top(RULER_MM, length_mm);
        let lines = lines.iter().skip(usize::from(one_line));
        self.band_mm() + lines.map(Line::height_mm).sum::<f64>()
    }

    fn legend(&self, length_mm: f64) -> (Vec<Line>, f64) {
        let lines = legend(&self.board, &self.options.name, self.scale);
        let lines: Vec<_> = lines
            .iter()
            .flat_map(|line| line.wrapped(length_mm))
            .collect();
        let height = lines.iter().map(Line::height_mm).sum::<f64>();
        (lines, height)
    }

    /// What a ruler of a small board takes, from the side of the field on, mm.
    fn ruler_mm(&self) -> f64 {
        self.first_mm([0.0; 2])[0] + RULER_MM + overhang_mm(self.scale)
    }

    /// How far the ruler of a small board reaches beyond the legend below the field, mm.
    fn beyond_mm(&self, legend_mm: f64) -> f64 {
        (self.ruler_mm() - self.field_mm[1] - LEGEND_GAP_MM - legend_mm).max(0.0)
    }

    fn below(&self, page_mm: [f64; 2]) -> Arrangement {
        let (margin, band) = (self.options.margin_mm, self.band_mm());
        let [field_width, field_height] = self.field_mm;
        let width = 2.0 * margin + band + field_width.max(least_length_mm(self.scale));
        let page_width = if page_mm[0].is_finite() {
            page_mm[0]
        } else {
            width
        };
        // a page that is too narrow is looked at as wide as it would have to be, to say how high it must be
        let wide = page_width.max(width);
        let room = wide - 2.0 * margin - band;
        let left = margin + band + 0.5 * (room - field_width.max(self.ruler_mm()).min(room));
        let (legend, legend_mm) = self.legend(wide - margin - left);
        let top = self.top_mm(wide - margin - left + band);
        let height = 2.0 * margin + top + field_height + LEGEND_GAP_MM + legend_mm;
        let page_height = if page_mm[1].is_finite() {
            page_mm[1]
        } else {
            height
        };
        Arrangement {
            side: Side::Below,
            page_mm: [page_width, page_height],
            needed_mm: [width, height],
            field_mm: [
                left,
                margin + top + 0.5 * (page_height - height - self.beyond_mm(legend_mm)).max(0.0),
            ],
            legend,
            legend_mm,
        }
    }

    fn beside(&self, page_mm: [f64; 2]) -> Arrangement {
        let (margin, band) = (self.options.margin_mm, self.band_mm());
        let [field_width, field_height] = self.field_mm;
        let least = least_length_mm(self.scale);
        let top = self.top_mm((band + field_width).max(least));
        let height = 2.0 * margin + top + field_height.max(least);
        let page_height = if page_mm[1].is_finite() {
            page_mm[1]
        } else {
            height
        };
        let tall = page_height.max(height);
        let upper = margin + top + 0.5 * (tall - 2.0 * margin - top - field_height);
        let (legend, legend_mm) = self.legend(tall - margin - upper);
        let content = (band + field_width + LEGEND_GAP_MM + legend_mm).max(least);
        let width = 2.0 * margin + content;
        let page_width = if page_mm[0].is_finite() {
            page_mm[0]
        } else {
            width
        };
        Arrangement {
            side: Side::Beside,
            page_mm: [page_width, page_height],
            needed_mm: [width, height],
            field_mm: [margin + band + 0.5 * (page_width - width), upper],
            legend,
            legend_mm,
        }
    }
}
