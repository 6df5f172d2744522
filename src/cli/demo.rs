//! `ringcal demo`: a simulated camera, the node, and what it makes of the frames.
//!
//! The camera is in this process and publishes over DDS on the loopback interface; the node is a process of its own that gets
//! the board file and the frames and nothing else.

mod camera;
mod child;
mod table;

use super::output::print;
use crate::board::Board;
use crate::ros::client::{CameraClient, ClientError};
use crate::ros::messages::{CameraInfo, Header, RingCentreArray};
use crate::ros::network::{DiscoveryRange, Network};
use anyhow::{Context, bail, ensure};
use camera::{Shot, SimulatedCamera};
use child::{NodeProcess, free_domain};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use table::{CentreErrors, table};

/// The board that the demonstration shows.
const BOARD: &str = include_str!("../../config/a4.yaml");

/// Where the node stands in the graph, and what it listens to.
const NODE: &str = "/ringcal";
const TOPIC: &str = "/image";

/// Times that even a slow machine keeps.
const START: Duration = Duration::from_secs(15);
const LOOK: Duration = Duration::from_secs(5);
const SOLVE: Duration = Duration::from_secs(30);

/// How often a frame is sent again where it got lost, as frames may: the node listens best effort.
const TRIES: usize = 4;

/// Frames of each place: the node keeps none before the board has been still for two.
const FRAMES_PER_VIEW: u64 = 2;

/// Largest error of the focal lengths that passes, fraction.
const PASSES: f64 = 0.01;

/// Arguments of `ringcal demo`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Places the board is held at.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(10..=60))]
    views: u16,
    /// Standard deviation of the Gaussian blur, px.
    #[arg(long, value_name = "PX", default_value_t = 3.0)]
    blur_sigma: f64,
    /// Another seed gives other places and other noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs the demonstration; progress goes to stderr, the result to stdout.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&interrupted))?;
    }
    let board = Board::from_yaml(BOARD)?;
    let camera = SimulatedCamera::new(
        board,
        usize::from(arguments.views),
        arguments.blur_sigma,
        arguments.seed,
    )?;
    let domain = free_domain().context("no DDS domain is free on this machine")?;
    let mut node = NodeProcess::start(BOARD, domain)?;
    let network = Network {
        domain,
        range: DiscoveryRange::Localhost,
    };
    let (context, _) = network.join().context("DDS")?;
    let asked = move || interrupted.load(Ordering::Relaxed);
    let client = CameraClient::open(&context, "simulated_camera", NODE, TOPIC, asked)?;
    let found = demonstrate(&client, &camera, &mut node);
    drop(client);
    drop(context);
    node.end()?;
    let (info, rms_px, centres) = found?;
    let table = table(camera.truth(), &info, rms_px, &centres);
    print(&format!("{table}\n"))?;
    let error = (info.k[0] / camera.truth().intrinsics.fx - 1.0).abs();
    ensure!(
        error < PASSES,
        "the focal length is off by {:.2} %",
        100.0 * error
    );
    Ok(())
}

/// Shows every view, has the node calibrate, and brings back what it says.
fn demonstrate(
    client: &CameraClient,
    camera: &SimulatedCamera,
    node: &mut NodeProcess,
) -> anyhow::Result<(CameraInfo, f64, CentreErrors)> {
    eprintln!("waiting for the node");
    client
        .wait_for_node(START)
        .map_err(|error| node.reason_for(error))?;
    let mut centres = CentreErrors::default();
    for view in 0..camera.views() {
        let mut last = Header::default();
        for frame in 0..FRAMES_PER_VIEW {
            let shot = camera.take(view, frame)?;
            let seen = show(client, &shot).map_err(|error| node.reason_for(error))?;
            if !seen.reason.is_empty() {
                eprintln!("view {}: {}", view + 1, seen.reason);
            }
            centres.add(&shot.truth, &seen);
            last = seen.header;
        }
        let status = client.status_with("the status", LOOK, |status| status.header == last)?;
        eprintln!(
            "view {:2} of {}: {} kept, {:.0} % of the frame covered, blur {:.1} px: {}",
            view + 1,
            camera.views(),
            status.views,
            100.0 * status.coverage,
            status.blur_sigma,
            status.guidance
        );
    }
    eprintln!("calling {NODE}/calibrate");
    let answer = client.calibrate(SOLVE)?;
    eprintln!("{}", answer.message);
    if !answer.success {
        bail!("not calibrated: {}", answer.message);
    }
    let info = client.camera_info(LOOK)?;
    let status = client.status_with("the calibration's status", LOOK, |s| !s.rms.is_nan())?;
    Ok((info, status.rms, centres))
}

/// Publishes a frame until the node answers it.
fn show(client: &CameraClient, shot: &Shot) -> Result<RingCentreArray, ClientError> {
    let mut last = ClientError::Interrupted;
    for _ in 0..TRIES {
        client.publish(shot.image.clone())?;
        match client.centres_of(&shot.image.header, LOOK) {
            Err(error @ ClientError::Late { .. }) => last = error,
            other => return other,
        }
    }
    Err(last)
}
