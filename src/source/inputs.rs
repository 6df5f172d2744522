//! All inputs of a command, opened before the first frame is read, so that a mistake shows at once.

use super::bag::{self, Bag, Topic, TopicError};
use super::recorded::Recorded;
use super::{SourceError, folder};
use std::path::{Path, PathBuf};

/// Image files, folders of them and bags, in the order given.
#[derive(Debug)]
pub struct Inputs {
    inputs: Vec<Input>,
}

/// What comes out of inputs.
#[derive(Debug)]
pub enum Item {
    /// The next frame.
    Frame(Recorded),
    /// Something that is wrong with an input and stops nothing, a sentence that begins with its path.
    Warning(String),
}

/// An input of one kind; a new kind of input is a new variant here.
#[derive(Debug)]
enum Input {
    Image(PathBuf),
    /// Its files, and what is left aside in it.
    Folder(Vec<PathBuf>, Option<String>),
    Bag(Bag, Topic),
    Broken(PathBuf, SourceError),
}

impl Inputs {
    /// Looks at every path: a file is itself, a folder its image files in natural order (view_2 before view_10), a bag the messages
    /// of one topic in the order in which they were recorded. What cannot be read becomes a frame with the reason, and the
    /// rest go on.
    ///
    /// # Errors
    /// [`TopicError`] where it is not clear which topic of a bag is meant; `topic` names it.
    pub fn open(
        paths: impl IntoIterator<Item = PathBuf>,
        topic: Option<&str>,
    ) -> Result<Self, TopicError> {
        let open = |path| Input::open(path, topic);
        let inputs = paths.into_iter().map(open).collect::<Result<_, _>>()?;
        Ok(Self { inputs })
    }

    /// Whether there is a bag among them.
    pub fn have_bags(&self) -> bool {
        self.inputs
            .iter()
            .any(|input| matches!(input, Input::Bag(..)))
    }

    /// How many frames there are; `None` where a bag has not been counted.
    pub fn frame_count(&self) -> Option<u64> {
        let count = |input: &Input| match input {
            Input::Image(_) | Input::Broken(..) => Some(1),
            Input::Folder(files, _) => Some(files.len() as u64),
            Input::Bag(_, topic) => topic.messages,
        };
        self.inputs
            .iter()
            .map(count)
            .try_fold(0_u64, |sum, count| Some(sum.saturating_add(count?)))
    }

    /// The files that are read: image files, and whatever else was given that is no bag.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.inputs
            .iter()
            .flat_map(|input| match input {
                Input::Image(path) | Input::Broken(path, _) => std::slice::from_ref(path),
                Input::Folder(files, _) => files,
                Input::Bag(..) => &[],
            })
            .map(PathBuf::as_path)
    }

    /// The frames of all inputs. Files are opened when the iterator comes to them; one message of a bag is in memory at a time.
    pub fn items(self) -> impl Iterator<Item = Item> {
        self.inputs.into_iter().flat_map(Input::items)
    }
}

impl Input {
    fn open(path: PathBuf, topic: Option<&str>) -> Result<Self, TopicError> {
        if bag::is_bag(&path) {
            return match Bag::open(&path) {
                Ok(bag) => {
                    let topic = bag.topic(topic)?.clone();
                    Ok(Self::Bag(bag, topic))
                }
                Err(error) => Ok(Self::Broken(path, error.into())),
            };
        }
        if !path.is_dir() {
            return Ok(Self::Image(path));
        }
        Ok(match folder::image_files(&path) {
            Ok(files) => Self::Folder(files, bags_left_aside(&path)),
            Err(error) => Self::Broken(path, error),
        })
    }

    fn items(self) -> Box<dyn Iterator<Item = Item>> {
        let file = |path| Item::Frame(Recorded::file(path));
        match self {
            Self::Image(path) => Box::new(std::iter::once(path).map(file)),
            Self::Folder(files, note) => {
                let note = note.map(Item::Warning).into_iter();
                Box::new(note.chain(files.into_iter().map(file)))
            }
            Self::Broken(path, error) => {
                let nothing = Recorded::nothing(path, error);
                Box::new(std::iter::once(Item::Frame(nothing)))
            }
            Self::Bag(bag, topic) => Box::new(of_bag(&bag, &topic)),
        }
    }
}

/// A folder of pictures that holds files of bags too.
fn bags_left_aside(folder: &Path) -> Option<String> {
    let (first, count) = bag::first_in_folder(folder)?;
    let others = if count > 1 {
        format!(" and {} more files of bags", count - 1)
    } else {
        String::new()
    };
    Some(format!(
        "{}: only its pictures are looked at; a bag in it is an input of its own: {}{others}",
        folder.display(),
        first.display()
    ))
}

/// What is wrong with the bag, its frames, and where its files end early.
fn of_bag(bag: &Bag, topic: &Topic) -> impl Iterator<Item = Item> + use<> {
    let notes: Vec<Item> = bag.notes().iter().cloned().map(Item::Warning).collect();
    let path = bag.path().to_owned();
    let mut number = 0;
    let messages = bag.messages(topic).map(move |message| match message {
        Ok(message) => {
            number += 1;
            Item::Frame(Recorded::message(&path, number - 1, message))
        }
        Err(breakoff) => Item::Warning(format!("{}: {breakoff}", breakoff.file.display())),
    });
    notes.into_iter().chain(messages)
}
