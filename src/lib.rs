//! ringcal: camera calibration from a small board of concentric circles held close to the lens, out of focus.
//!
//! # From a frame to a calibration
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use ringcal::board::Board;
//! use ringcal::calibrate::{CalibrateOptions, calibrate};
//! use ringcal::detect::{DetectOptions, Detector};
//! use ringcal::session::{Session, SessionRules, View};
//! # use ringcal::{camera::{Camera, Intrinsics, PlumbBob}, simulate::{Defocus, Scene, render, views}};
//! # let intrinsics = Intrinsics { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5 };
//! # let truth = Camera { width: 640, height: 480, intrinsics, distortion: PlumbBob::default().into() };
//! # let text = include_str!("../config/a4.yaml");
//!
//! let board = Board::from_yaml(text)?;
//! # let frames = views(&truth, &board, 6, 0.6, 1)?.into_iter().map(|pose| {
//! #     let scene = Scene { defocus: Defocus::gaussian(2.0), ..Scene::new(truth, board.clone(), pose) };
//! #     render(&scene, 0).map(|rendering| rendering.frame)
//! # });
//! let detector = Detector::new(board.clone(), DetectOptions::default());
//! let mut session = Session::new(board.clone(), SessionRules::for_files());
//! for (number, frame) in frames.enumerate() { // of a camera out of focus; source::Inputs reads them from files and bags
//!     let detection = detector.detect(&frame?)?;
//!     session.offer(View::of_file(format!("frame {number}"), &detection));
//! }
//! let calibration = calibrate(&board, session.views(), &CalibrateOptions::default())?;
//! assert!((calibration.camera.intrinsics.fx - 600.0).abs() < 1.0); // px; the true focal length is 600
//! # Ok(()) }
//! ```
//!
//! # Map
//! | | module | what goes in | what comes out |
//! |---|---|---|---|
//! | the way of the data | [`frame`] | bytes of a message or a file | [`Frame`](frame::Frame): grey, 8 or 16 bit |
//! | | [`enhance`] | `Frame` | the frame with its edges sharpened (paper III-A), to look at |
//! | | [`detect`] | `Frame`, [`Board`](board::Board) | [`Detection`](detect::Detection): every ring with row, column and centre |
//! | | [`centre`] | a ring's two ellipses, or its pixels | its projected centre, by one of six estimators (paper III-C) |
//! | | [`session`] | `Detection` after `Detection` | the [`View`](session::View)s worth keeping, coverage, what to show next |
//! | | [`calibrate`](mod@calibrate) | `View`s | [`Calibration`](calibrate::Calibration): camera, poses, residuals, covariance |
//! | | [`refine`](mod@refine) | `View`s, `Calibration` | the `View`s with better centres, to calibrate from again |
//! | what it speaks of | [`board`], [`camera`] | | the print; pinhole, lens, pose, homography |
//! | its surroundings | [`source`], [`formats`], [`report`] | | image files and bags; files read and written; pictures and pages |
//! | the print | [`print`](mod@print) | `Board`, paper; or a camera | the sheet as SVG, PDF or PNG; or the board for that camera |
//! | | [`ros`], [`cli`] | | the ROS 2 node; the subcommands |
//! | the truth | [`simulate`] | camera, pose, defocus, noise | a frame and where its rings truly are |
//!
//! Only the surroundings read, write, or know of DDS. Everything else is computation: the same input gives the same result, whatever the number of
//! threads.
//!
//! # Conventions
//! Pixels: x right, y down, (0, 0) is the centre of the top-left pixel. Lengths in metres, angles in radians (REP 103); names
//! say the unit (`pitch_m`, `blur_sigma_px`). Camera frame: x right, y down, z forward. "Paper equation 26" and the like refer
//! to the paper that docs/method.md follows step by step.

pub mod board;
pub mod calibrate;
pub mod camera;
pub mod centre;
pub mod cli;
pub mod detect;
pub mod enhance;
pub mod formats;
pub mod frame;
mod plural;
pub mod print;
pub mod refine;
pub mod report;
pub mod ros;
pub mod session;
pub mod simulate;
pub mod source;
