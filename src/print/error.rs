//! Why a board cannot be printed.

use super::numbers::decimal;

/// What stands in the way of a print, with the sizes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PrintError {
    /// No paper of this name or size.
    #[error(
        "{text} is no paper: give a name ({names}) or WIDTHxHEIGHT in mm, 20 to 5000 each, for example 600x400"
    )]
    Paper {
        /// What was given.
        text: String,
        /// The names there are.
        names: String,
    },
    /// The board is larger than the paper.
    #[error(
        "the board does not fit: its {} x {} mm of rings and quiet zone need, with rulers, text and margins, \
         {} x {} mm of paper, and {paper} has {} x {} mm{}",
        decimal(field_mm[0], 1), decimal(field_mm[1], 1), decimal(needed_mm[0], 1), decimal(needed_mm[1], 1),
        decimal(paper_mm[0], 1), decimal(paper_mm[1], 1), hint(larger.as_deref())
    )]
    DoesNotFit {
        /// Rings and quiet zone, width and height, mm.
        field_mm: [f64; 2],
        /// Least width and height of the paper, mm.
        needed_mm: [f64; 2],
        /// The paper's name.
        paper: String,
        /// The paper's width and height, mm.
        paper_mm: [f64; 2],
        /// A paper that would hold it.
        larger: Option<String>,
    },
    /// It is wider than the roll whichever way it is turned.
    #[error(
        "the board does not fit: its {} x {} mm of rings and quiet zone need a roll at least {} mm wide, with rulers and margins, \
         not {} mm",
        decimal(field_mm[0], 1), decimal(field_mm[1], 1), decimal(*needed_mm, 1), decimal(*roll_mm, 1)
    )]
    WiderThanRoll {
        /// Rings and quiet zone, width and height, mm.
        field_mm: [f64; 2],
        /// Least width of the roll, mm.
        needed_mm: f64,
        /// Its width, mm.
        roll_mm: f64,
    },
    /// It would take more of the roll than any page may be long.
    #[error("the board takes {} mm of the roll, a page is at most {} mm long", decimal(*needed_mm, 0), decimal(*most_mm, 0))]
    TooLong {
        /// Length that it takes, mm.
        needed_mm: f64,
        /// The longest page, mm.
        most_mm: f64,
    },
    /// A picture of more pixels than anybody prints.
    #[error(
        "at {} dpi the sheet of {} x {} mm is {width} x {height} px, more than {} million: use fewer --dpi, or PDF, which has no pixels",
        decimal(*dpi, 1), decimal(sheet_mm[0], 1), decimal(sheet_mm[1], 1), most / 1_000_000
    )]
    Pixels {
        /// Pixels an inch.
        dpi: f64,
        /// Size of the sheet, mm.
        sheet_mm: [f64; 2],
        /// Columns it would have.
        width: u64,
        /// Rows it would have.
        height: u64,
        /// The most pixels of a picture.
        most: u64,
    },
    /// So few pixels that not even the rings show.
    #[error("at {} dpi a pixel is {} mm wide, wider than the rings' narrowest part ({} mm): use at least {} dpi", decimal(*dpi, 1),
        decimal(25.4 / dpi, 3), decimal(*width_mm, 3), decimal((25.4 / width_mm).ceil(), 0))]
    TooCoarse {
        /// Pixels an inch.
        dpi: f64,
        /// Narrowest part of a ring, mm.
        width_mm: f64,
    },
    /// The encoder refused.
    #[error("the picture cannot be encoded: {0}")]
    Encoding(String),
}

fn hint(larger: Option<&str>) -> String {
    match larger {
        Some(name) => format!("; --paper {name} holds it"),
        None => "; use a larger --paper WIDTHxHEIGHT or --roll WIDTH (mm)".to_owned(),
    }
}
