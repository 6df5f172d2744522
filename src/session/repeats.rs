//! Frames of a recording that show what the frames before them showed, told without looking for the board.
//!
//! Of a board that is held still for a second the first frame shows that it is there and the next one that it is still; from then
//! on each frame tells what is known. So a frame is a repeat where it looks like both of the last two that were
//! looked at. A board that creeps is noticed, for the comparison is with those two and not with the frame before.

use crate::frame::Thumbnail;

/// The largest difference of two cells of a thumbnail, of 255, that is noise or a motion that makes no new view: a cell of 4 x 4 px and
/// more averages noise of 1 % of full scale to 0.6, and a sharp edge changes its cell by this when it moves by less than a tenth of it.
const SAME: f32 = 5.0;

/// Tells repeats in one stream of frames.
#[derive(Debug, Clone, Default)]
pub struct Repeats {
    looked_at: [Option<Thumbnail>; 2],
}

impl Repeats {
    /// Whether a frame repeats those that were looked at; where it does not, it is taken for one that is looked at.
    pub fn is_repeat(&mut self, frame: Thumbnail) -> bool {
        let same = |known: &Thumbnail| known.difference(&frame).is_some_and(|most| most < SAME);
        let repeats = self
            .looked_at
            .iter()
            .all(|known| known.as_ref().is_some_and(same));
        if !repeats {
            self.looked_at.rotate_left(1);
            self.looked_at[1] = Some(frame);
        }
        repeats
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Frame, Plane};

    /// A dark bar whose left edge is at x, px.
    fn bar(x: f64) -> Thumbnail {
        let grey = |at: usize| {
            let covered = ((at % 320) as f64 + 1.0 - x).clamp(0.0, 1.0);
            (200.0 - 150.0 * covered) as u8
        };
        let pixels = (0..320 * 240).map(grey).collect();
        Thumbnail::of(&Frame::from_u8(
            Plane::from_vec(320, 240, pixels).unwrap(),
            "a",
        ))
    }

    #[test]
    fn the_third_of_equal_frames_is_a_repeat() {
        let mut repeats = Repeats::default();
        let told: Vec<bool> = [50.0, 100.0, 100.0, 100.0, 100.0, 50.0, 50.0, 50.0]
            .map(|x| repeats.is_repeat(bar(x)))
            .into();
        let expected = [false, false, false, true, true, false, false, true];
        assert_eq!(told, expected);
    }

    #[test]
    fn what_creeps_is_looked_at_again_and_again() {
        let mut repeats = Repeats::default();
        let looked_at = (0..400)
            .filter(|at| !repeats.is_repeat(bar(100.0 + 0.02 * f64::from(*at))))
            .count();
        // 8 px: less than a fifth of a pixel shows
        assert!((40..300).contains(&looked_at), "{looked_at}");
    }
}
