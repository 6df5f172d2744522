//! Which shape of blur the user wants fitted.

use super::blur::Psf;
use std::fmt;
use std::str::FromStr;

/// Which blur to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PsfChoice {
    /// The likelier.
    #[default]
    Auto,
    /// This one.
    Fixed(Psf),
}

impl PsfChoice {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 3] = [
        Self::Auto,
        Self::Fixed(Psf::Gaussian),
        Self::Fixed(Psf::Disc),
    ];

    /// The name on the command line and in parameters.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Fixed(psf) => psf.name(),
        }
    }
}

impl fmt::Display for PsfChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for PsfChoice {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|choice| choice.name() == name)
            .ok_or_else(|| {
                let known = Self::ALL.map(Self::name).join(", ");
                format!("unknown shape of blur {name:?}; known are {known}")
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for choice in PsfChoice::ALL {
            assert_eq!(choice.to_string().parse(), Ok(choice));
        }
        assert_eq!("auto".parse(), Ok(PsfChoice::default()));
        for wrong in ["", "Disc", "pillbox", "gaussian "] {
            let reason = wrong.parse::<PsfChoice>().unwrap_err();
            assert!(reason.ends_with("auto, gaussian, disc"), "{reason}");
        }
    }
}
