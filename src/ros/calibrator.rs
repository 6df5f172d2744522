//! What the node knows between frames: session, calibration, counters; and what it says about them.
//!
//! No DDS, no clock and no threads here: the worker hands in what it saw and publishes what comes back.

use super::camera_info::camera_info;
use super::inbox::FrameCounts;
use super::job::{Job, Solved, describe, options};
use super::messages::{CalibrationStatus, CameraInfo, Header, RingCentre, RingCentreArray};
use super::settings::Settings;
use crate::board::Board;
use crate::calibrate::{Calibration, Estimate};
use crate::camera::Camera;
use crate::detect::{Detection, Indices};
use crate::session::{Offer, Session};
use std::time::Duration;

/// The parameters together with the board they name.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// The parameters.
    pub settings: Settings,
    /// What stands in the board file.
    pub board: Board,
}

/// The answer to a request, as std_srvs/srv/Trigger has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// It was done.
    Done(String),
    /// It was not, and why.
    Refused(String),
}

/// A frame's header and size.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameFacts {
    /// Stamp and `frame_id`.
    pub header: Header,
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
}

/// The camera that a calibration is about.
#[derive(Debug, Clone, PartialEq)]
struct Calibrated {
    calibration: Calibration,
    frame_id: String,
}

/// The state of the node.
#[derive(Debug)]
pub struct Calibrator {
    configuration: Configuration,
    session: Session,
    /// Counts the sessions: what was solved for an earlier one is not believed.
    session_number: u64,
    calibrated: Option<Calibrated>,
    solving: bool,
    /// Views that had ever been kept at the last calibration that was started without being asked.
    tried_at: usize,
    status: CalibrationStatus,
}

impl Calibrator {
    /// A node that has seen no frame; `topic` is where it waits for them.
    pub fn new(configuration: Configuration, topic: &str) -> Self {
        let settings = &configuration.settings;
        let mut session = Session::new(configuration.board.clone(), settings.rules);
        session.set_options(options(settings, None));
        let status = CalibrationStatus {
            guidance: format!("waiting for frames on {topic}"),
            rms: f64::NAN,
            predicted_fx_std: f64::NAN,
            projection_std: f64::NAN,
            ..Default::default()
        };
        Self {
            configuration,
            session,
            session_number: 0,
            calibrated: None,
            solving: false,
            tried_at: 0,
            status,
        }
    }

    /// The board and parameters in force.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// What has been collected.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Takes in a frame that was looked at, and answers with its centres.
    ///
    /// `found` is the detection or why there is none; `processing` the time from decoded pixels to centres.
    pub fn observe(
        &mut self,
        frame: &FrameFacts,
        found: Result<&Detection, String>,
        processing: Duration,
    ) -> RingCentreArray {
        self.status.header = frame.header.clone();
        self.status.frames_processed += 1;
        self.status.processing_time = processing.as_secs_f64();
        self.status.board_found = found.is_ok();
        let (frame_id, stamp) = (&frame.header.frame_id, frame.header.stamp.into());
        let board = found.as_ref().copied();
        let offer = self.session.observe(frame_id, stamp, board).ok();
        match found {
            Ok(detection) => {
                self.status.blur_sigma = detection.blur_sigma_px();
                if let Some(offer) = offer {
                    self.offered(&offer, detection);
                }
                self.centres(frame, detection)
            }
            Err(reason) => {
                self.status.blur_sigma = 0.0;
                self.status.guidance.clone_from(&reason);
                self.no_centres(frame, reason)
            }
        }
    }

    /// Takes in a frame that could not be decoded, and answers with the reason in place of centres.
    pub fn failed(&mut self, frame: &FrameFacts, reason: String) -> RingCentreArray {
        self.status.header = frame.header.clone();
        self.status.frames_failed += 1;
        self.status.board_found = false;
        self.status.blur_sigma = 0.0;
        self.status.guidance.clone_from(&reason);
        if self.status.last_error != reason {
            tracing::error!("frame not usable: {reason}");
            self.status.last_error.clone_from(&reason);
        }
        self.session.missed();
        self.no_centres(frame, reason)
    }

    /// Says what became of a frame with the board.
    fn offered(&mut self, offer: &Offer, detection: &Detection) {
        let restarted = offer.restart.is_some();
        if restarted {
            self.forget();
            tracing::warn!("{offer}");
        }
        self.status.guidance = if offer.kept() {
            if !restarted {
                tracing::info!("{offer}");
            }
            for note in detection.notes() {
                tracing::info!("{note}");
            }
            self.session.guidance().to_string()
        } else {
            offer.to_string()
        };
    }

    /// What was solved or is being solved is about another session than the one that begins.
    fn forget(&mut self) {
        self.session_number += 1;
        self.calibrated = None;
        self.tried_at = 0;
    }

    fn no_centres(&self, frame: &FrameFacts, reason: String) -> RingCentreArray {
        RingCentreArray {
            header: frame.header.clone(),
            width: frame.width,
            height: frame.height,
            rows: self.configuration.board.rows(),
            columns: self.configuration.board.columns(),
            indices_absolute: false,
            centres: Vec::new(),
            reason,
        }
    }

    fn centres(&self, frame: &FrameFacts, detection: &Detection) -> RingCentreArray {
        let centres = detection.rings.iter().map(|ring| {
            let covariance = ring.centre.covariance;
            RingCentre {
                row: ring.row,
                column: ring.column,
                x: ring.centre.point.x,
                y: ring.centre.point.y,
                covariance: covariance.map_or([f64::NAN; 3], |c| [c[(0, 0)], c[(0, 1)], c[(1, 1)]]),
                blur_sigma: ring.blur_sigma_px,
            }
        });
        RingCentreArray {
            indices_absolute: detection.indices == Indices::Absolute,
            centres: centres.collect(),
            ..self.no_centres(frame, String::new())
        }
    }

    /// What ~/status says.
    pub fn status(&self, counts: FrameCounts) -> CalibrationStatus {
        let status = &self.status;
        let state = if self.solving {
            "calibrating"
        } else if self.calibrated.is_some() {
            "calibrated"
        } else if status.frames_processed + status.frames_failed == 0 {
            "waiting"
        } else {
            "collecting"
        };
        let rules = self.session.rules();
        let progress = self.session.progress();
        let estimate = self.session.estimate();
        let least_certain = estimate.and_then(Estimate::least_certain);
        CalibrationStatus {
            state: state.to_owned(),
            views: number(self.session.views().len()),
            min_views: number(rules.min_views),
            max_views: number(rules.max_views),
            coverage: self.session.coverage(),
            frames_received: counts.received,
            frames_dropped: counts.dropped,
            rms: self
                .calibrated
                .as_ref()
                .map_or(f64::NAN, |c| c.calibration.rms_px),
            progress_x: progress.x,
            progress_y: progress.y,
            progress_size: progress.size,
            progress_skew: progress.skew,
            predicted_fx_std: estimate.map_or(f64::NAN, Estimate::fx_std_px),
            projection_std: least_certain.map_or(f64::NAN, |(_, std_px)| std_px),
            ..status.clone()
        }
    }

    /// The calibration in the form of a message, without a header; `None` before there is one.
    pub fn camera_info(&self) -> Option<CameraInfo> {
        let calibrated = self.calibrated.as_ref()?;
        let mut info = camera_info(&calibrated.calibration.camera);
        info.header.frame_id.clone_from(&calibrated.frame_id);
        Some(info)
    }

    /// The calibration with a frame's header, where it is of that frame's camera.
    pub fn camera_info_of(&self, frame: &FrameFacts) -> Option<CameraInfo> {
        let info = self.camera_info()?;
        let same = info.width == frame.width
            && info.height == frame.height
            && info.header.frame_id == frame.header.frame_id;
        same.then(|| CameraInfo {
            header: frame.header.clone(),
            ..info
        })
    }

    /// The camera to save, and under which name.
    ///
    /// # Errors
    /// A sentence where there is no calibration yet.
    pub fn to_save(&self) -> Result<(&Camera, &Settings), String> {
        match &self.calibrated {
            Some(calibrated) => Ok((&calibrated.calibration.camera, &self.configuration.settings)),
            None => Err("there is no calibration yet: call ~/calibrate first".to_owned()),
        }
    }

    /// Starts a calibration.
    ///
    /// # Errors
    /// A sentence where one is being solved already or views are missing.
    pub fn start_calibration(&mut self) -> Result<Job, String> {
        if self.solving {
            return Err("busy: a calibration is being solved".to_owned());
        }
        let (views, needed) = (self.session.views().len(), self.session.rules().min_views);
        if !self.session.is_ready() {
            let reason = format!(
                "{views} of the {needed} views needed have been collected: {}",
                self.session.guidance()
            );
            self.status.last_result.clone_from(&reason);
            return Err(reason);
        }
        self.solving = true;
        Ok(Job {
            session: self.session_number,
            board: self.configuration.board.clone(),
            views: self.session.views().to_vec(),
            model: self.configuration.settings.model,
            options: options(&self.configuration.settings, None),
        })
    }

    /// A calibration that nobody asked for, where the parameter auto_calibrate wants one now.
    pub fn start_automatically(&mut self) -> Option<Job> {
        let views = self.session.ever_kept();
        let more = (self.session.rules().max_views / 4).max(1);
        let due = self.tried_at == 0 || views >= self.tried_at + more;
        let wanted = self.configuration.settings.auto_calibrate && due;
        if !wanted || self.solving || !self.session.is_enough() {
            return None;
        }
        self.tried_at = views;
        self.start_calibration().ok()
    }

    /// Takes in what was solved.
    pub fn finish_calibration(&mut self, solved: Solved) -> Answer {
        self.solving = false;
        let answer = if solved.session != self.session_number {
            Answer::Refused("started anew while it was being solved; the result was dropped".into())
        } else {
            match solved.result {
                Ok(calibration) => {
                    let text = describe(&calibration, solved.views);
                    // views of a session are all of one frame_id
                    let frame_id = self.session.views().first().map(|v| v.frame_id.clone());
                    let model = calibration.camera.model();
                    let settings = &self.configuration.settings;
                    self.session.set_options(options(settings, Some(model)));
                    self.calibrated = Some(Calibrated {
                        calibration,
                        frame_id: frame_id.unwrap_or_default(),
                    });
                    Answer::Done(text)
                }
                Err(error) => Answer::Refused(format!("not calibrated: {error}")),
            }
        };
        match &answer {
            Answer::Done(text) => tracing::info!("{text}"),
            Answer::Refused(text) => tracing::warn!("{text}"),
        }
        let (Answer::Done(text) | Answer::Refused(text)) = &answer;
        self.status.last_result.clone_from(text);
        answer
    }

    /// Gives up a calibration that ended without a result.
    pub fn abandon_calibration(&mut self) -> Answer {
        self.solving = false;
        let reason = "the calibration could not be run; please report this as a bug".to_owned();
        tracing::error!("{reason}");
        self.status.last_result.clone_from(&reason);
        Answer::Refused(reason)
    }

    /// Forgets the views and the calibration.
    pub fn reset(&mut self) -> Answer {
        let views = self.session.views().len();
        self.session.reset();
        self.forget();
        self.status.guidance = self.session.guidance().to_string();
        self.status.last_result.clear();
        let text = format!("{views} views forgotten");
        tracing::info!("{text}");
        Answer::Done(text)
    }

    /// Takes over new parameters. Another board or another way to measure starts anew: views of different ones do not mix.
    pub fn configure(&mut self, new: Configuration) {
        let board = self.session.set_board(new.board.clone());
        let measuring = self
            .configuration
            .settings
            .measures_differently(&new.settings);
        let changed = board.then_some("board").or(measuring);
        self.session.set_rules(new.settings.rules);
        let model = self
            .calibrated
            .as_ref()
            .map(|c| c.calibration.camera.model());
        self.session.set_options(options(&new.settings, model));
        if let Some(what) = changed {
            self.session.reset();
            self.forget();
            self.status.guidance = format!("another {what}: started anew");
            tracing::warn!("another {what}: started anew");
        }
        self.configuration = new;
    }
}

fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests;
