//! `ringcal simulate`: frames of a defocused board and the truth about them.
//!
//! Standard output has one line per frame, its path. `truth.json` is written last: where it exists, the frames are complete.

mod options;
mod truth_file;

use super::output::print;
use crate::board::Board;
use crate::frame::{Frame, Pixels};
use crate::simulate::{BitDepth, Light, Scene, Sensor, render, views};
use crate::source::read_board;
use anyhow::{Context, bail};
use image::{ImageBuffer, ImageFormat, Luma};
use std::io::Cursor;
use std::path::Path;
use truth_file::{TruthFile, ViewTruth};

pub use options::Arguments;

/// Runs the command.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let board = read_board(&arguments.board)?;
    let scenes = scenes(arguments, &board)?;
    let output = &arguments.output;
    std::fs::create_dir_all(output).with_context(|| output.display().to_string())?;
    let names = frame_names(arguments.views, arguments.frames_per_view);
    refuse_other_frames(output, &names)?;
    let truth_path = output.join("truth.json");
    if truth_path.exists() {
        std::fs::remove_file(&truth_path).with_context(|| truth_path.display().to_string())?;
    }
    let mut truth = TruthFile::new(&scenes[0].camera);
    for (index, name) in names.iter().enumerate() {
        let scene = &scenes[index / arguments.frames_per_view as usize];
        // every frame has noise of its own
        let seed = arguments.seed.wrapping_add((index as u64) << 32);
        let rendering = render(scene, seed).with_context(|| format!("cannot render {name}"))?;
        let path = output.join(name);
        write_whole(&path, &png(rendering.frame)?)?;
        truth
            .views
            .push(ViewTruth::new(name, scene, &rendering.truth));
        // whoever reads the names or not: the frames are what is wanted
        print(&format!("{}\n", path.display()))?;
        eprintln!("{} of {} frames", index + 1, names.len());
    }
    write_whole(&truth_path, &serde_json::to_vec_pretty(&truth)?)
}

/// One scene for each view.
fn scenes(arguments: &Arguments, board: &Board) -> anyhow::Result<Vec<Scene>> {
    let camera = arguments.camera()?;
    let count = usize::from(arguments.views);
    let max_tilt_rad = arguments.max_tilt.to_radians();
    let poses = views(&camera, board, count, max_tilt_rad, arguments.seed)?;
    let defocus = arguments.defocus(&camera)?;
    let with_pose = |pose| Scene {
        defocus,
        light: Light {
            shading: [arguments.shading, 0.0],
            ..Light::on(board.polarity())
        },
        sensor: Sensor {
            depth: if arguments.depth == 16 {
                BitDepth::Sixteen
            } else {
                BitDepth::Eight
            },
            read_noise: arguments.noise,
            full_well_electrons: arguments.full_well,
            gamma: arguments.gamma,
        },
        ..Scene::new(camera, board.clone(), pose)
    };
    Ok(poses.into_iter().map(with_pose).collect())
}

/// Names of all frames, in order.
fn frame_names(views: u16, frames_per_view: u16) -> Vec<String> {
    let of_view = |view| {
        (0..frames_per_view).map(move |frame| {
            if frames_per_view == 1 {
                format!("view_{view:03}.png")
            } else {
                format!("view_{view:03}_{frame:02}.png")
            }
        })
    };
    (0..views).flat_map(of_view).collect()
}

/// Frames of another run beside the new ones would be taken for views of the same camera.
fn refuse_other_frames(output: &Path, names: &[String]) -> anyhow::Result<()> {
    for entry in std::fs::read_dir(output).with_context(|| output.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let frame = name.starts_with("view_") && name.ends_with(".png");
        if frame && !names.contains(&name) {
            bail!(
                "{} holds {name} of another run; remove it or choose another folder",
                output.display()
            );
        }
    }
    Ok(())
}

/// The frame as a PNG file.
fn png(frame: Frame) -> anyhow::Result<Vec<u8>> {
    let (width, height) = (
        u32::try_from(frame.width())?,
        u32::try_from(frame.height())?,
    );
    let mut file = Cursor::new(Vec::new());
    match frame.pixels {
        Pixels::U8(plane) => ImageBuffer::<Luma<u8>, _>::from_raw(width, height, plane.data())
            .context("the frame has another size than its pixels")?
            .write_to(&mut file, ImageFormat::Png)?,
        Pixels::U16(plane) => ImageBuffer::<Luma<u16>, _>::from_raw(width, height, plane.data())
            .context("the frame has another size than its pixels")?
            .write_to(&mut file, ImageFormat::Png)?,
    }
    Ok(file.into_inner())
}

/// Writes a file under a temporary name beside it and renames it, so that nobody sees a part of it.
fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    let written = std::fs::write(&partial, bytes).and_then(|()| std::fs::rename(&partial, path));
    if written.is_err() {
        // the first failure is the one to report
        let _ = std::fs::remove_file(&partial);
    }
    written.with_context(|| path.display().to_string())
}
