//! A frame at all its scales, each computed when it is first asked for: pictures, what stands out in them, and the rings seen there.
//! Pictures and what stands out are the same for dark rings and for light ones.

use super::band_pass::BandPass;
use super::candidates::{Seen, candidates, disc_candidates};
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::{Frame, Level, Pixels, Plane, half, half_of_frame, quarter_of_frame};

/// Levels whose shorter side is below this hold no ring that a lower level has not shown, px.
const LEAST_SIDE_PX: usize = 24;

/// The levels of one frame, looked at for dark or for light rings.
pub(super) struct Scales<'a> {
    pub(super) frame: &'a Frame,
    /// 1 for dark rings, -1 for light ones.
    pub(super) sign: f64,
    ratio: f64,
    levels: Vec<Scale>,
}

/// What is known of one level.
#[derive(Default)]
struct Scale {
    picture: Option<Plane<f32>>,
    band: Option<BandPass>,
    /// Dark ones and light ones.
    rings: [Option<Vec<RingEllipses>>; 2],
}

impl<'a> Scales<'a> {
    /// Of a frame with rings of this inner over outer radius.
    pub(super) fn new(frame: &'a Frame, sign: f64, ratio: f64) -> Self {
        let side = frame.width().min(frame.height());
        let count = (1..usize::BITS).take_while(|level| side >> level >= LEAST_SIDE_PX);
        Self {
            frame,
            sign,
            ratio,
            levels: (0..=count.count()).map(|_| Scale::default()).collect(),
        }
    }

    /// Looks for dark rings (1) or for light ones (-1) from now on.
    pub(super) fn turn_to(&mut self, sign: f64) {
        self.sign = sign;
    }

    /// How many levels there are.
    pub(super) fn count(&self) -> usize {
        self.levels.len()
    }

    /// Candidates for rings at a level, in frame pixels.
    pub(super) fn rings(&mut self, level: usize) -> &[RingEllipses] {
        let which = usize::from(self.sign < 0.0);
        if self.levels[level].rings[which].is_none() {
            let ratio = self.ratio;
            let found = self.see(level, |seen, level| candidates(seen, level, ratio));
            self.levels[level].rings[which] = Some(found);
        }
        self.levels[level].rings[which]
            .as_deref()
            .unwrap_or_default()
    }

    /// Outlines at a level of discs that may be rings whose inner disc has drowned, in frame pixels.
    pub(super) fn discs(&mut self, level: usize) -> Vec<Ellipse> {
        self.see(level, disc_candidates)
    }

    fn see<C>(&mut self, level: usize, find: impl Fn(Seen, Level) -> Vec<C>) -> Vec<C> {
        if self.levels[level].band.is_none() {
            self.levels[level].band = self.band(level);
        }
        let sign = self.sign as f32;
        let band = self.levels[level].band.as_ref();
        band.map_or_else(Vec::new, |band| {
            find(Seen { band, sign }, Level(level as u32))
        })
    }

    fn band(&mut self, level: usize) -> Option<BandPass> {
        if level > 0 {
            return Some(BandPass::of(self.picture(level)?));
        }
        Some(match &self.frame.pixels {
            Pixels::U8(plane) => BandPass::of(plane),
            Pixels::U16(plane) => BandPass::of(plane),
        })
    }

    /// The picture of a level from 1 on. The second is made from the frame, so that the first, four times as large, is made only
    /// for small rings.
    fn picture(&mut self, level: usize) -> Option<&Plane<f32>> {
        if self.levels[level].picture.is_none() {
            self.levels[level].picture = match level {
                1 => half_of_frame(self.frame),
                2 => quarter_of_frame(self.frame),
                _ => half(self.picture(level - 1)?),
            };
        }
        self.levels[level].picture.as_ref()
    }
}
