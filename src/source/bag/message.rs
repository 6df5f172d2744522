//! One recorded image message: its bytes, and what they say.

use super::cdr::{Cdr, CdrError};
use super::zstd::{self, UnpackError};
use crate::frame::{DecodeError, Frame, FrameError, RawImage, Stamp};

/// No message is longer, bytes; an image of 100 megapixels in four bytes each is 400 MB.
pub(super) const LONGEST_MESSAGE: usize = 512 << 20;

/// The two messages that carry images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ImageKind {
    /// sensor_msgs/msg/Image.
    Raw,
    /// sensor_msgs/msg/CompressedImage.
    Compressed,
}

impl ImageKind {
    /// Of a message type by its ROS name; `None` for every other message.
    pub fn of_type(name: &str) -> Option<Self> {
        [Self::Raw, Self::Compressed]
            .into_iter()
            .find(|kind| kind.type_name() == name)
    }

    /// The message type's ROS name.
    pub fn type_name(self) -> &'static str {
        match self {
            Self::Raw => "sensor_msgs/msg/Image",
            Self::Compressed => "sensor_msgs/msg/CompressedImage",
        }
    }
}

/// A message as it was recorded, not looked into yet: that may be done on another thread.
#[derive(Debug)]
pub struct ImageMessage {
    pub(super) kind: ImageKind,
    /// CDR, or a zstd frame of it.
    pub(super) data: Result<Vec<u8>, MessageError>,
    /// When it was recorded, ns since 1970.
    pub(super) recorded_ns: i64,
}

/// Why a message gives no frame.
#[derive(Debug, thiserror::Error)]
pub enum MessageError {
    /// Longer than any image.
    #[error("the message is {bytes} bytes long, more than the {LONGEST_MESSAGE} that are read")]
    TooLong {
        /// Its length, bytes.
        bytes: u64,
    },
    /// Its compression is damaged.
    #[error("{0}")]
    Packed(#[from] UnpackError),
    /// Its fields cannot be told apart.
    #[error("{0}")]
    Cdr(#[from] CdrError),
    /// The pixels of an Image.
    #[error("{0}")]
    Raw(#[from] FrameError),
    /// The picture of a CompressedImage.
    #[error("the compressed image: {0}")]
    Compressed(#[from] DecodeError),
}

/// What a message says.
#[derive(Debug)]
pub struct RecordedFrame {
    /// When the image was taken; zero where the message does not say.
    pub stamp: Stamp,
    /// Coordinate frame of the camera; empty where the message does not say.
    pub frame_id: String,
    /// The picture, or why there is none; its `source` is the `frame_id`.
    pub frame: Result<Frame, MessageError>,
}

impl ImageMessage {
    /// Reads the message.
    pub fn decode(self) -> RecordedFrame {
        let mut header = (Stamp::default(), String::new());
        let frame = self.data.and_then(|data| {
            let data = zstd::unpack_message(data)?;
            let mut cdr = Cdr::new(&data)?;
            header = header_of(&mut cdr)?;
            picture(self.kind, &mut cdr, header.0, &header.1)
        });
        RecordedFrame {
            stamp: header.0,
            frame_id: header.1,
            frame,
        }
    }
}

fn header_of(cdr: &mut Cdr) -> Result<(Stamp, String), CdrError> {
    let sec = cdr.i32("header.stamp")?;
    let nanosec = cdr.u32("header.stamp")?;
    let frame_id = cdr.string("header.frame_id")?;
    Ok((Stamp { sec, nanosec }, frame_id))
}

fn picture(
    kind: ImageKind,
    cdr: &mut Cdr,
    stamp: Stamp,
    frame_id: &str,
) -> Result<Frame, MessageError> {
    match kind {
        ImageKind::Raw => {
            let raw = RawImage {
                height: cdr.u32("height")?,
                width: cdr.u32("width")?,
                encoding: cdr.string("encoding")?,
                is_bigendian: cdr.u8("is_bigendian")? != 0,
                step: cdr.u32("step")?,
                data: cdr.bytes("data")?.to_vec(),
            };
            Ok(raw.into_frame(stamp, frame_id)?)
        }
        ImageKind::Compressed => {
            // a hint at most: the picture's first bytes say what it is
            let _format = cdr.string("format")?;
            Ok(Frame::decode(cdr.bytes("data")?, stamp, frame_id)?)
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::frame::{Pixels, Plane};
    use proptest::prelude::*;

    /// Writes a message, little endian.
    pub(crate) struct Writer(Vec<u8>);

    impl Writer {
        pub(crate) fn new(sec: i32, frame_id: &str) -> Self {
            let mut writer = Self(vec![0, 1, 0, 0]);
            writer.u32(sec.cast_unsigned());
            writer.u32(500_000_000);
            writer.bytes(format!("{frame_id}\0").as_bytes());
            writer
        }

        pub(crate) fn u32(&mut self, value: u32) {
            self.0.resize(self.0.len().next_multiple_of(4), 0);
            self.0.extend(value.to_le_bytes());
        }

        pub(crate) fn bytes(&mut self, bytes: &[u8]) {
            self.u32(bytes.len() as u32);
            self.0.extend(bytes);
        }
    }

    /// A mono8 Image, 4 x 3 px, all of one grey value.
    pub(crate) fn image(sec: i32, grey: u8) -> Vec<u8> {
        let mut writer = Writer::new(sec, "camera");
        writer.u32(3);
        writer.u32(4);
        writer.bytes(b"mono8\0");
        writer.0.push(0);
        writer.u32(4);
        writer.bytes(&[grey; 12]);
        writer.0
    }

    /// A CompressedImage of the same.
    fn compressed(sec: i32, grey: u8) -> Vec<u8> {
        let mut png = std::io::Cursor::new(Vec::new());
        let picture = image::GrayImage::from_pixel(4, 3, image::Luma([grey]));
        picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let mut writer = Writer::new(sec, "camera");
        writer.bytes(b"mono8; png compressed \0");
        writer.bytes(png.get_ref());
        writer.0
    }

    fn decoded(kind: ImageKind, data: Vec<u8>) -> RecordedFrame {
        ImageMessage {
            kind,
            data: Ok(data),
            recorded_ns: 0,
        }
        .decode()
    }

    #[test]
    fn both_messages_give_the_picture_with_its_header() {
        for (kind, data) in [
            (ImageKind::Raw, image(-7, 99)),
            (ImageKind::Compressed, compressed(-7, 99)),
            (
                ImageKind::Raw,
                ::zstd::encode_all(&*image(-7, 99), 1).unwrap(),
            ),
        ] {
            let recorded = decoded(kind, data);
            let frame = recorded.frame.unwrap();
            assert_eq!(frame.pixels, Pixels::U8(Plane::filled(4, 3, 99)));
            let (sec, nanosec) = (-7, 500_000_000);
            assert_eq!(recorded.stamp, Stamp { sec, nanosec });
            assert_eq!(frame.stamp, recorded.stamp);
            assert_eq!((&*recorded.frame_id, &*frame.source), ("camera", "camera"));
        }
    }

    #[test]
    fn a_cut_message_says_where_it_ends_and_keeps_its_header() {
        let whole = image(1, 5);
        for cut in 0..whole.len() {
            let recorded = decoded(ImageKind::Raw, whole[..cut].to_vec());
            assert!(recorded.frame.is_err(), "{cut} bytes");
        }
        let recorded = decoded(ImageKind::Raw, whole[..whole.len() - 1].to_vec());
        assert_eq!(recorded.frame_id, "camera");
        let message = recorded.frame.unwrap_err().to_string();
        assert!(message.contains("in the middle of its data"), "{message}");
    }

    proptest! {
        #[test]
        fn no_bytes_cause_a_panic(
            header in prop::sample::select(vec![[0_u8, 0], [0, 1], [0x28, 0xb5]]),
            rest in prop::collection::vec(any::<u8>(), 0..200),
            at in 0_usize..60,
        ) {
            let mut data = header.to_vec();
            data.extend(&rest);
            decoded(ImageKind::Raw, data.clone());
            decoded(ImageKind::Compressed, data);
            // and a good one with one part overwritten
            let mut data = image(1, 5);
            for (byte, new) in data[at..].iter_mut().zip(&rest) {
                *byte = *new;
            }
            decoded(ImageKind::Raw, data);
        }
    }
}
