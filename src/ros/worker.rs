//! The thread that looks at frames and answers the services.
//!
//! One thing at a time and in the order of the inbox, except that a calibration is solved on a thread of its own, so that
//! frames are still looked at meanwhile.

use super::calibrator::{Answer, Calibrator, Configuration, FrameFacts};
use super::inbox::{Inbox, Next};
use super::job::{Job, Solved};
use super::messages::{CameraInfo, Image};
use super::pictures::{Picture, drawn};
use super::publishers::{Listeners, Publishers};
use super::save::save;
use crate::detect::{DetectOptions, Detection, Detector, Miss};
use crate::enhance::{Target, enhance};
use crate::frame::{Frame, RawImage};
use ros2_client::Context;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The status is published at least this often.
const STATUS_PERIOD: Duration = Duration::from_secs(1);

/// Sends the answer to whoever asked.
pub type Reply = Box<dyn FnOnce(Answer) + Send>;

/// What the worker can be told.
pub enum Command {
    /// ~/calibrate.
    Calibrate(Reply),
    /// ~/reset.
    Reset(Reply),
    /// ~/save.
    Save(Reply),
    /// Parameters were set.
    Configure(Box<Configuration>),
    /// A calibration was solved, or its thread ended without a result.
    Solved(Option<Box<Solved>>),
}

/// The inbox of the worker.
pub type WorkerInbox = Inbox<Image, Command>;

/// The worker's own.
pub struct Worker {
    calibrator: Calibrator,
    detector: Detector,
    inbox: Arc<WorkerInbox>,
    publishers: Publishers,
    context: Context,
    /// Where ~/save writes unless told otherwise.
    ros_home: PathBuf,
    /// Who waits for the calibration that is being solved.
    waiting: Option<Reply>,
}

impl Worker {
    /// A worker for `inbox` that publishes through `publishers`; `topic` is where the frames come from.
    pub fn new(
        configuration: Configuration,
        topic: &str,
        inbox: Arc<WorkerInbox>,
        publishers: Publishers,
        context: Context,
        ros_home: PathBuf,
    ) -> Self {
        Self {
            detector: detector(&configuration),
            calibrator: Calibrator::new(configuration, topic),
            inbox,
            publishers,
            context,
            ros_home,
            waiting: None,
        }
    }

    /// Works until the inbox is closed.
    pub fn run(mut self) {
        loop {
            let counts = self.inbox.counts();
            self.publishers.status(self.calibrator.status(counts));
            match self.inbox.next(STATUS_PERIOD) {
                Next::Closed => return,
                Next::Nothing => {}
                Next::Frame(image) => self.look_at(image),
                Next::Command(command) => self.obey(command),
            }
        }
    }

    fn look_at(&mut self, image: Image) {
        let facts = FrameFacts {
            header: image.header.clone(),
            width: image.width,
            height: image.height,
        };
        let stamp = image.header.stamp.into();
        let raw = RawImage {
            width: image.width,
            height: image.height,
            encoding: image.encoding,
            is_bigendian: image.is_bigendian != 0,
            step: image.step,
            data: image.data,
        };
        let frame = match raw.into_frame(stamp, image.header.frame_id) {
            Ok(frame) => frame,
            Err(error) => {
                let centres = self.calibrator.failed(&facts, error.to_string());
                return self.publishers.centres(centres);
            }
        };
        let start = Instant::now();
        let found = self.detector.detect(&frame);
        let processing = start.elapsed();
        let result = found.as_ref().map_err(ToString::to_string);
        let calibrated = self.calibrator.camera_info().is_some();
        let centres = self.calibrator.observe(&facts, result, processing);
        self.publishers.centres(centres);
        match self.calibrator.camera_info_of(&facts) {
            Some(info) => self.publishers.camera_info(info),
            // the frame was of another camera than the calibration
            None if calibrated => self.retract_camera_info(),
            None => {}
        }
        self.show(&facts, frame, found.as_ref());
        if let Some(job) = self.calibrator.start_automatically() {
            self.solve(job, None);
        }
    }

    /// Draws and publishes the pictures that somebody wants to see.
    fn show(&self, facts: &FrameFacts, frame: Frame, found: Result<&Detection, &Miss>) {
        let listeners = Listeners::now(&self.context);
        let settings = &self.calibrator.configuration().settings;
        self.publishers
            .debug(&listeners, &facts.header, settings, || {
                drawn(&frame, self.calibrator.session(), found)
            });
        self.publishers
            .enhanced(&listeners, &facts.header, settings, || {
                // a board of unknown polarity is shown as the usual print
                let polarity = self.detector.board().polarity();
                let target = Target::of(polarity).unwrap_or(Target::Dark);
                Some(Picture::Grey(
                    enhance(&frame, target, NonZeroU32::MIN).frame,
                ))
            });
    }

    fn obey(&mut self, command: Command) {
        match command {
            Command::Calibrate(reply) => match self.calibrator.start_calibration() {
                Ok(job) => self.solve(job, Some(reply)),
                Err(reason) => reply(Answer::Refused(reason)),
            },
            Command::Solved(solved) => self.solved(solved),
            Command::Reset(reply) => {
                let answer = self.calibrator.reset();
                self.retract_camera_info();
                reply(answer);
            }
            Command::Save(reply) => reply(self.save()),
            Command::Configure(configuration) => {
                self.detector = detector(&configuration);
                let calibrated = self.calibrator.camera_info().is_some();
                self.calibrator.configure(*configuration);
                if calibrated && self.calibrator.camera_info().is_none() {
                    self.retract_camera_info();
                }
            }
        }
    }

    fn solve(&mut self, job: Job, reply: Option<Reply>) {
        self.waiting = reply;
        let inbox = Arc::clone(&self.inbox);
        let started = std::thread::Builder::new()
            .name("calibrate".to_owned())
            .spawn(move || {
                // should the solver ever panic, the node must not stay busy for good
                let solved = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| job.solve()));
                inbox.put_command(Command::Solved(solved.ok().map(Box::new)));
            });
        if let Err(error) = started {
            tracing::error!("no thread for the calibration: {error}");
            self.solved(None);
        }
    }

    fn solved(&mut self, solved: Option<Box<Solved>>) {
        let answer = match solved {
            Some(solved) => self.calibrator.finish_calibration(*solved),
            None => self.calibrator.abandon_calibration(),
        };
        if matches!(answer, Answer::Done(_))
            && let Some(info) = self.calibrator.camera_info()
        {
            self.publishers.camera_info(info);
        }
        if let Some(reply) = self.waiting.take() {
            reply(answer);
        }
    }

    fn save(&self) -> Answer {
        let saved = self.calibrator.to_save().and_then(|(camera, settings)| {
            save(
                camera,
                &settings.camera_name,
                &settings.folder(&self.ros_home),
            )
            .map_err(|error| error.to_string())
        });
        match saved {
            Ok(path) => {
                let text = format!("saved {}", path.display());
                tracing::info!("{text}");
                Answer::Done(text)
            }
            Err(reason) => {
                tracing::warn!("not saved: {reason}");
                Answer::Refused(reason)
            }
        }
    }

    /// Late subscribers must not get a calibration that does not hold any more: zeros mean uncalibrated.
    fn retract_camera_info(&self) {
        self.publishers.camera_info(CameraInfo::default());
    }
}

fn detector(configuration: &Configuration) -> Detector {
    let settings = &configuration.settings;
    let options = DetectOptions {
        estimator: settings.estimator,
        psf: settings.psf,
        response_gamma: settings.response_gamma,
        required: settings.required,
        // none is known before it is calibrated
        camera: None,
    };
    Detector::new(configuration.board.clone(), options)
}
