//! The camera's response: how its grey values follow the light.
//!
//! The blur mixes light, so the model of a blurred ring is one of light. A camera whose grey values are not proportional
//! to it (most that make pictures for people) bends the edges, which costs a tenth of a pixel or more.

use std::fmt;
use std::str::FromStr;

/// What is known of the response: grey = light^(1 / gamma), both from 0 (black) to 1 (full scale).
///
/// The frame is linearised with it before the photometric fit: light = grey^gamma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ResponseGamma {
    /// Gamma is known, [`ResponseGamma::LEAST`] to [`ResponseGamma::GREATEST`]; 1 where grey values are proportional to
    /// light.
    Fixed(f64),
    /// Gamma is estimated from the frame.
    Auto,
}

impl ResponseGamma {
    /// The smallest gamma that can be given.
    pub const LEAST: f64 = 0.2;
    /// The greatest gamma that can be given.
    pub const GREATEST: f64 = 5.0;
}

impl Default for ResponseGamma {
    /// Grey values are proportional to light, as those of most cameras for machines are.
    fn default() -> Self {
        Self::Fixed(1.0)
    }
}

impl fmt::Display for ResponseGamma {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // `{:?}`: with a decimal point always, "1.0"
            Self::Fixed(gamma) => f.pad(&format!("{gamma:?}")),
            Self::Auto => f.pad("auto"),
        }
    }
}

impl FromStr for ResponseGamma {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        // NaN and the infinities lie outside the range
        text.parse()
            .ok()
            .filter(|gamma| (Self::LEAST..=Self::GREATEST).contains(gamma))
            .map(Self::Fixed)
            .ok_or_else(|| {
                let (least, greatest) = (Self::LEAST, Self::GREATEST);
                format!("{text:?} is neither auto nor a number from {least} to {greatest}")
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_is_read_back() {
        for (response, shown) in [
            (ResponseGamma::Auto, "auto"),
            (ResponseGamma::default(), "1.0"),
            (ResponseGamma::Fixed(2.2), "2.2"),
            (ResponseGamma::Fixed(1.0 / 2.2), "0.45454545454545453"),
            (ResponseGamma::Fixed(ResponseGamma::LEAST), "0.2"),
            (ResponseGamma::Fixed(ResponseGamma::GREATEST), "5.0"),
        ] {
            assert_eq!(response.to_string(), shown);
            assert_eq!(shown.parse(), Ok(response));
        }
        assert_eq!("1".parse(), Ok(ResponseGamma::Fixed(1.0)));
    }

    #[test]
    fn anything_else_is_refused_with_what_can_be_given() {
        for wrong in [
            "", "Auto", "srgb", "0", "-1", "0.19", "5.01", "nan", "inf", "2,2",
        ] {
            let reason = wrong.parse::<ResponseGamma>().unwrap_err();
            let expected = format!("{wrong:?} is neither auto nor a number from 0.2 to 5");
            assert_eq!(reason, expected);
        }
    }
}
