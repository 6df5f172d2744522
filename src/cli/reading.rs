//! What `detect`, `calibrate` and `check` are told about their inputs.

use crate::session::SessionRules;
use crate::source::Inputs;
use std::path::PathBuf;

/// Options of a command that reads bags.
#[derive(Debug, Clone, clap::Args)]
pub struct Reading {
    /// The topic of the bags, where they have several with images.
    #[arg(long, value_name = "NAME")]
    topic: Option<String>,
}

impl Reading {
    /// Opens inputs that all have to be there.
    ///
    /// # Errors
    /// A path where nothing is, and as of [`Reading::open`].
    pub fn open_existing(&self, paths: &[PathBuf]) -> anyhow::Result<Inputs> {
        if let Some(path) = paths.iter().find(|path| !path.exists()) {
            anyhow::bail!("{}: no such file or folder", path.display());
        }
        self.open(paths)
    }

    /// Opens all inputs; one where nothing is becomes a frame that cannot be read.
    ///
    /// # Errors
    /// A bag in which the topic is not clear, a topic where there is no bag.
    pub fn open(&self, paths: &[PathBuf]) -> anyhow::Result<Inputs> {
        let inputs = Inputs::open(paths.iter().cloned(), self.topic.as_deref())?;
        anyhow::ensure!(
            self.topic.is_none() || inputs.have_bags(),
            "--topic is for rosbag2 bags, and none of the inputs is one"
        );
        Ok(inputs)
    }
}

/// Options of a command that collects views.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Collecting {
    #[command(flatten)]
    pub rules: StreamRules,
    /// Say nothing of the progress and of the frames that went well.
    #[arg(long)]
    pub quiet: bool,
}

/// Which frames of a bag become views: the node's rules, for a bag is the same stream of frames.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct StreamRules {
    /// Of a bag: the board is still where no ring moved by more than this since the frame before; 0 does not ask for stillness.
    #[arg(long, value_name = "PX", default_value_t = 2.0, value_parser = not_negative)]
    max_motion_px: f64,
    /// Of a bag: views kept at most; then a view takes the place of the one that tells least.
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(3..=1000))]
    max_views: u16,
}

impl StreamRules {
    /// For a session that chooses the views which tell most about the camera, as the node does.
    pub fn to_calibrate(self) -> SessionRules {
        let usual = SessionRules::default();
        let max_views = usize::from(self.max_views);
        SessionRules {
            max_motion_px: (self.max_motion_px > 0.0).then_some(self.max_motion_px),
            min_views: usual.min_views.min(max_views),
            max_views,
            ..usual
        }
    }

    /// For a session whose views are held against a camera that is known: none is refused for contradicting the others.
    pub fn to_check(self) -> SessionRules {
        SessionRules {
            least_gain: None,
            target_px: None,
            ..self.to_calibrate()
        }
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number >= 0.0 && number.is_finite() => Ok(number),
        _ => Err("it must be a number from 0 on".to_owned()),
    }
}
