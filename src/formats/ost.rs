//! ost.txt, the INI file of camera_calibration and camera_calibration_parsers.
//!
//! Sections in brackets, keys on lines of their own and the numbers on the lines below. The file has no key for the lens
//! model: five coefficients are `plumb_bob`, eight `rational_polynomial` (so read the parsers of ROS 2 and of ROS 1 Noetic, older
//! ones five alone), and a fisheye has no place. camera_calibration rounds to six digits behind the point; here every digit is kept.

use super::camera_file_error::{CameraFileError, CannotExpress};
use super::camera_info::CameraInfo;
use super::choice::choose;
use super::pinhole::{self, finite, lens_by_count};
use super::yaml_number::number;
use crate::camera::LensModel;

const NAME: &str = "ost.txt";

/// The text of the file.
pub(super) fn write(info: &CameraInfo) -> Result<String, CannotExpress> {
    let (camera, name) = (&info.camera, &info.camera_name);
    if camera.model() == LensModel::Equidistant {
        return Err(CannotExpress::Model {
            format: NAME,
            model: camera.model(),
        });
    }
    let odd = |c: char| matches!(c, '[' | ']') || c.is_control();
    if name.contains(odd) || matches!(name.as_str(), "image" | "externals") {
        return Err(CannotExpress::Name {
            format: NAME,
            name: name.clone(),
            why: "it stands between brackets on a line of its own, where image and externals mean something else",
        });
    }
    let matrix = |key: &str, values: &[f64], columns: usize| {
        let row = |row: &[f64]| row.iter().map(|v| number(*v)).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = values.chunks(columns).map(row).collect();
        format!("\n{key}\n{}\n", rows.join("\n"))
    };
    let distortion = camera.distortion.coefficients();
    Ok(format!(
        "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n{}\n\nheight\n{}\n\n[{name}]\n",
        camera.width, camera.height
    ) + &matrix("camera matrix", &info.camera_matrix(), 3)
        + &matrix("distortion", &distortion, distortion.len())
        + &matrix("rectification", &info.rectification, 3)
        + &matrix("projection", &info.projection, 4))
}

/// Reads the text of a file; of several cameras the one that is wanted.
pub(super) fn read(text: &str, wanted: Option<&str>) -> Result<CameraInfo, CameraFileError> {
    let sections = sections(text);
    // a size belongs to the cameras below it
    let mut image = None;
    let mut cameras = Vec::new();
    for section in &sections {
        match section.name {
            "image" => image = Some(section),
            "externals" => {}
            _ => cameras.push((image, section)),
        }
    }
    let names: Vec<&str> = cameras.iter().map(|(_, section)| section.name).collect();
    if names.is_empty() {
        return Err(syntax("it has no section of a camera".to_owned()));
    }
    let (image, camera) = cameras[choose(&names, wanted)?];
    let image = image.ok_or_else(|| syntax("it has no section [image] first".to_owned()))?;
    let size = (image.pixels("width")?, image.pixels("height")?);
    let k = camera.matrix("camera matrix")?;
    let distortion = camera.numbers("distortion")?;
    let lens = match distortion.len() {
        5 | 8 => lens_by_count("distortion", &distortion)?,
        _ => None,
    };
    let lens = lens.ok_or_else(|| CameraFileError::Count {
        name: "distortion",
        values: distortion.len(),
        expected: "5 (plumb_bob) or 8 (rational_polynomial)".to_owned(),
    })?;
    let read = pinhole::camera(size, pinhole::intrinsics(&k)?, lens)?;
    let mut info = CameraInfo::new(camera.name, read);
    info.rectification = camera.matrix("rectification")?;
    info.projection = camera.matrix("projection")?;
    Ok(info)
}

fn syntax(reason: String) -> CameraFileError {
    CameraFileError::Syntax {
        format: "an ost.txt file",
        reason,
    }
}

/// What stands below one name in brackets.
struct Section<'a> {
    name: &'a str,
    lines: Vec<&'a str>,
}

fn sections(text: &str) -> Vec<Section<'_>> {
    let lines = text.lines().map(str::trim);
    let said = lines.filter(|line| !line.is_empty() && !line.starts_with(['#', ';']));
    let mut sections: Vec<Section> = Vec::new();
    for line in said {
        match line
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
        {
            Some(name) => sections.push(Section {
                name,
                lines: Vec::new(),
            }),
            None => sections
                .last_mut()
                .into_iter()
                .for_each(|s| s.lines.push(line)),
        }
    }
    sections
}

impl Section<'_> {
    /// The lines behind a key, as far as they hold numbers.
    fn words(&self, key: &'static str) -> Result<Vec<&str>, CameraFileError> {
        let at = self.lines.iter().position(|line| *line == key);
        let Some(at) = at else {
            return Err(syntax(format!("section [{}] has no {key}", self.name)));
        };
        let numeric = |line: &&&str| {
            let first = line.split_whitespace().next();
            first.is_some_and(|word| word.parse::<f64>().is_ok())
        };
        let lines = self.lines[at + 1..].iter().take_while(numeric);
        Ok(lines.flat_map(|line| line.split_whitespace()).collect())
    }

    fn numbers(&self, key: &'static str) -> Result<Vec<f64>, CameraFileError> {
        let number = |word: &str| {
            word.parse::<f64>()
                .map_err(|_| syntax(format!("{word:?} below {key} is no number")))
        };
        let values: Vec<f64> = self
            .words(key)?
            .into_iter()
            .map(number)
            .collect::<Result<_, _>>()?;
        finite(key, &values)?;
        Ok(values)
    }

    fn matrix<const N: usize>(&self, key: &'static str) -> Result<[f64; N], CameraFileError> {
        let values = self.numbers(key)?;
        let count = values.len();
        values.try_into().map_err(|_| CameraFileError::Count {
            name: key,
            values: count,
            expected: N.to_string(),
        })
    }

    fn pixels(&self, key: &'static str) -> Result<u32, CameraFileError> {
        match self.words(key)?.as_slice() {
            [word] => word
                .parse()
                .map_err(|_| syntax(format!("{key} {word:?} is no number of pixels"))),
            words => Err(CameraFileError::Count {
                name: key,
                values: words.len(),
                expected: "1".to_owned(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;
    use crate::camera::Equidistant;

    #[test]
    fn the_text_is_that_of_camera_calibration_with_all_digits() {
        let text = write(&CameraInfo::new("front", wide())).unwrap();
        let expected = "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n[front]\n\n\
            camera matrix\n401.5 0.0 322.4\n0.0 399.2 236.1\n0.0 0.0 1.0\n\n\
            distortion\n-0.3 0.09 0.0008 -0.0012 -0.01\n\n\
            rectification\n1.0 0.0 0.0\n0.0 1.0 0.0\n0.0 0.0 1.0\n\n\
            projection\n401.5 0.0 322.4 0.0\n0.0 399.2 236.1 0.0\n0.0 0.0 1.0 0.0\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn other_spacing_comments_and_externals_are_read() {
        let text = "; a comment\n[image]\nwidth\n 640\nheight\n480\n[externals]\ntranslation\n1 2 3\nrotation\n0 0 0\n\
            [left/eye]\ncamera matrix\n500 0 320\n0 500 240\n0 0 1\ndistortion\n0.1 0 0 0 0\n\
            rectification\n1 0 0\n0 1 0\n0 0 1\nprojection\n500 0 320 0\n0 500 240 0\n0 0 1 0\n";
        let info = read(text, None).unwrap();
        assert_eq!(info.camera_name, "left/eye");
        assert_eq!(info.camera.distortion.coefficients()[0], 0.1);
        let pair = format!("{text}{}", text.replace("left/eye", "right/eye"));
        let said = read(&pair, None).unwrap_err().to_string();
        assert!(
            said.contains("several cameras: left/eye, right/eye"),
            "{said}"
        );
        assert_eq!(read(&pair, Some("left/eye")).unwrap(), info);
    }

    #[test]
    fn what_it_has_no_place_for_is_refused() {
        let fisheye = crate::camera::Camera {
            distortion: Equidistant { k: [0.0; 4] }.into(),
            ..wide()
        };
        let refused = |name: &str, camera| {
            let info = CameraInfo::new(name, camera);
            write(&info).unwrap_err().to_string()
        };
        assert_eq!(refused("a", fisheye), "ost.txt has no equidistant lens");
        assert!(refused("a]b", wide()).contains("camera name \"a]b\""));
        assert!(refused("image", wide()).contains("camera name"));
        assert!(refused("a\nb", wide()).contains("camera name"));
    }

    #[test]
    fn refusals_name_the_key() {
        let good = write(&CameraInfo::new("front", wide())).unwrap();
        let refused = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            read(&good.replace(from, to), None).unwrap_err().to_string()
        };
        assert!(refused("[front]", "front").contains("no section of a camera"));
        assert!(refused("[image]", "[externals]").contains("[image]"));
        assert!(refused("width\n640", "width\nmany").contains("width has 0 values"));
        assert!(refused("width\n640", "width\n-640").contains("\"-640\" is no number of pixels"));
        assert!(refused("distortion", "bending").contains("no distortion"));
        assert!(refused("-0.0012 -0.01", "-0.0012").contains("distortion has 4 values"));
        assert!(refused("-0.0012 -0.01", "-0.0012 NaN").contains("not finite"));
        assert!(refused("-0.0012 -0.01", "-0.0012 x").contains("\"x\" below distortion"));
        assert!(refused("401.5 0.0 322.4\n", "401.5 322.4\n").contains("camera matrix has 8"));
        assert!(refused("projection\n401.5", "projection\n").contains("projection has 11"));
    }
}
