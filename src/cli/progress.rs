//! How far a command is, on stderr: a bar on a terminal, a line every few seconds elsewhere, nothing where that is wanted.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Time between two lines.
const EVERY: Duration = Duration::from_secs(5);
/// Times a second that the bar is drawn at most.
const REDRAWS_HZ: u8 = 5;

/// What has been done so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counts {
    /// Frames looked at or passed over.
    pub frames: u64,
    /// Frames with the board.
    pub boards: u64,
    /// Views kept of bags.
    pub views: usize,
    /// How uncertain these views leave the camera where it is least certain, px at infinity, once they tell it.
    pub uncertain_px: Option<f64>,
}

/// Tells how far a command is.
#[derive(Debug)]
pub struct Progress {
    shown: Shown,
    /// Frames there are, where that is known.
    total: Option<u64>,
}

#[derive(Debug)]
enum Shown {
    Nothing,
    Bar(ProgressBar),
    Lines { began: Instant, told: Instant },
}

impl Progress {
    /// For so many frames.
    pub fn new(quiet: bool, total: Option<u64>) -> Self {
        let now = Instant::now();
        let shown = if quiet {
            Shown::Nothing
        } else if stderr().is_terminal() {
            Shown::Bar(bar(total))
        } else {
            Shown::Lines {
                began: now,
                told: now,
            }
        };
        Self { shown, total }
    }

    /// Tells what has been done, if it is time to.
    pub fn tell(&mut self, counts: Counts) {
        match &mut self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => {
                bar.set_position(counts.frames);
                bar.set_message(found(counts));
            }
            Shown::Lines { began, told } if told.elapsed() >= EVERY => {
                eprintln!("{}", line(counts, self.total, began.elapsed()));
                *told = Instant::now();
            }
            Shown::Lines { .. } => {}
        }
    }

    /// A remark, which nobody misses who wants it quiet.
    pub fn remark(&self, text: &str) {
        match &self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => bar.suspend(|| eprintln!("{text}")),
            Shown::Lines { .. } => eprintln!("{text}"),
        }
    }

    /// Something that is to be known in any case.
    pub fn warn(&self, text: &str) {
        match &self.shown {
            Shown::Bar(bar) => bar.suspend(|| eprintln!("warning: {text}")),
            Shown::Nothing | Shown::Lines { .. } => eprintln!("warning: {text}"),
        }
    }

    /// Takes the bar off the terminal: nothing more will be done.
    pub fn finish(&self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish_and_clear();
        }
    }
}

fn bar(total: Option<u64>) -> ProgressBar {
    let template = match total {
        Some(_) => "{bar:30} {pos} of {len} frames, {msg}, {eta} left",
        None => "{spinner} {pos} frames, {msg}, {elapsed}",
    };
    let target = ProgressDrawTarget::stderr_with_hz(REDRAWS_HZ);
    let bar = ProgressBar::with_draw_target(total, target);
    // a template that could not be read would leave the usual bar
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

fn found(counts: Counts) -> String {
    let uncertain = counts.uncertain_px.map_or_else(String::new, |px| {
        format!(", the camera uncertain by {px:.3} px at most")
    });
    let (boards, views) = (counts.boards, counts.views);
    format!("{boards} with the board, {views} views{uncertain}")
}

fn line(counts: Counts, total: Option<u64>, elapsed: Duration) -> String {
    let found = found(counts);
    let done = counts.frames;
    match total {
        Some(total) if (1..=total).contains(&done) => {
            let left_s = elapsed.as_secs_f64() * (total - done) as f64 / done as f64;
            format!("{done} of {total} frames, {found}, {left_s:.0} s left")
        }
        _ => format!("{done} frames, {found}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_what_was_done_and_how_long_the_rest_takes() {
        let counts = Counts {
            frames: 30,
            boards: 20,
            views: 7,
            uncertain_px: None,
        };
        let ten = Duration::from_secs(10);
        assert_eq!(
            line(counts, Some(120), ten),
            "30 of 120 frames, 20 with the board, 7 views, 30 s left"
        );
        for total in [None, Some(20)] {
            assert_eq!(
                line(counts, total, ten),
                "30 frames, 20 with the board, 7 views"
            );
        }
        let told = Counts {
            uncertain_px: Some(0.08124),
            ..counts
        };
        assert_eq!(
            line(told, None, ten),
            "30 frames, 20 with the board, 7 views, the camera uncertain by 0.081 px at most"
        );
    }
}
