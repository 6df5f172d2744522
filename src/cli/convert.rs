//! `ringcal convert`: a camera file in one format in, the same camera in another format out.

use super::output::print;
use crate::formats::{CameraFormat, write_by_rename};
use crate::source::read_camera_of;
use anyhow::Context;
use clap::error::ErrorKind;
use std::path::{Path, PathBuf};

/// Arguments of `ringcal convert`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A camera: camera_info YAML, ost.txt, OpenCV YAML or JSON, Kalibr camchain, mrcal cameramodel, calibration.json or truth.json.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write; - is stdout.
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Format to write: camera_info, ost, opencv, kalibr or mrcal. Without it the name of OUT tells: *.txt and *.ini are ost,
    /// *.cameramodel is mrcal, *camchain*.yaml is kalibr, *opencv*.yaml is opencv and any other *.yaml camera_info.
    #[arg(long, value_name = "NAME")]
    to: Option<CameraFormat>,
    /// The camera that is taken from a file of several, by its name there (cam0, cam1, ... in a camchain).
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Name of the camera in OUT [default: that in IN, or else camera]
    #[arg(long, value_name = "NAME")]
    camera_name: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let format = arguments.format()?;
    let mut info = read_camera_of(&arguments.input, arguments.camera.as_deref())?;
    for part in format.leaves_out(&info) {
        eprintln!("note: {format} has no place for {part}");
    }
    match &arguments.camera_name {
        Some(name) => info.camera_name.clone_from(name),
        // no driver is called nothing
        None if info.camera_name.is_empty() => info.camera_name = "camera".to_owned(),
        None => {}
    }
    let text = format
        .write(&info)
        .with_context(|| format!("{} cannot be written", arguments.output.display()))?;
    if arguments.output == Path::new("-") {
        print(&text)?;
    } else {
        write_by_rename(&arguments.output, text.as_bytes())
            .with_context(|| format!("{}: cannot be written", arguments.output.display()))?;
        eprintln!("wrote {}", arguments.output.display());
    }
    Ok(())
}

impl Arguments {
    /// The format asked for, by its name or by that of the file.
    fn format(&self) -> Result<CameraFormat, clap::Error> {
        let format = self.to.or_else(|| CameraFormat::of_path(&self.output));
        format.ok_or_else(|| {
            let name = self.output.display();
            let text =
                format!("the name {name} does not say in which format to write: give --to\n");
            clap::Error::raw(ErrorKind::MissingRequiredArgument, text)
        })
    }
}
