//! The structs against the .msg texts: what serde writes, field by field, must be what the text declares.

use super::*;
use serde::Serialize;
use serde::ser::{self, Impossible, SerializeSeq, SerializeStruct, SerializeTuple};
use std::fmt::Display;

/// (type, name) of every field, in order.
type Fields = Vec<(String, String)>;

/// The fields that a .msg text declares.
fn declared(text: &str) -> Fields {
    text.lines()
        .map(|line| line.split('#').next().unwrap_or(""))
        .filter(|line| !line.trim().is_empty() && !line.contains('='))
        .map(|line| {
            let mut words = line.split_whitespace();
            let kind = words.next().unwrap();
            // the package does not show in a Rust struct
            let kind = kind.rsplit('/').next().unwrap();
            (kind.to_owned(), words.next().unwrap().to_owned())
        })
        .collect()
}

/// What serde writes of a value: its ROS type, and its fields where it is a message.
struct Shape {
    kind: String,
    fields: Fields,
}

impl Shape {
    fn scalar(kind: impl Into<String>) -> Self {
        Self {
            kind: kind.into(),
            fields: Vec::new(),
        }
    }
}

/// The fields that serde writes of a message; sequences must hold at least one element.
fn written<T: Serialize>(message: &T) -> Fields {
    message.serialize(TypeOf).unwrap().fields
}

/// A serializer that writes down types.
struct TypeOf;

#[derive(Debug)]
struct Unused(String);

impl Display for Unused {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}
impl std::error::Error for Unused {}
impl ser::Error for Unused {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

macro_rules! scalar_types {
    ($($method:ident: $rust:ty => $ros:literal),* $(,)?) => {
        $(fn $method(self, _: $rust) -> Result<Shape, Unused> { Ok(Shape::scalar($ros)) })*
    };
}

macro_rules! no_such_values {
    ($($method:ident($($kind:ty),*)),* $(,)?) => {
        $(fn $method(self, $(_: $kind),*) -> Result<Self::Ok, Unused> {
            Err(Unused(stringify!($method).to_owned()))
        })*
    };
}

impl ser::Serializer for TypeOf {
    type Ok = Shape;
    type Error = Unused;
    type SerializeSeq = Elements;
    type SerializeTuple = Elements;
    type SerializeTupleStruct = Impossible<Shape, Unused>;
    type SerializeTupleVariant = Impossible<Shape, Unused>;
    type SerializeMap = Impossible<Shape, Unused>;
    type SerializeStruct = Shape;
    type SerializeStructVariant = Impossible<Shape, Unused>;

    scalar_types! {
        serialize_bool: bool => "bool",
        serialize_i8: i8 => "int8",
        serialize_i16: i16 => "int16",
        serialize_i32: i32 => "int32",
        serialize_i64: i64 => "int64",
        serialize_u8: u8 => "uint8",
        serialize_u16: u16 => "uint16",
        serialize_u32: u32 => "uint32",
        serialize_u64: u64 => "uint64",
        serialize_f32: f32 => "float32",
        serialize_f64: f64 => "float64",
        serialize_str: &str => "string",
        serialize_bytes: &[u8] => "uint8[]",
    }
    no_such_values! {
        serialize_char(char), serialize_none(), serialize_unit(), serialize_unit_struct(&'static str),
        serialize_unit_variant(&'static str, u32, &'static str),
    }

    fn serialize_some<T: Serialize + ?Sized>(self, _: &T) -> Result<Shape, Unused> {
        Err(Unused("an option".to_owned()))
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<Shape, Unused> {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<Shape, Unused> {
        Err(Unused("an enum".to_owned()))
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Elements, Unused> {
        Ok(Elements {
            length: String::new(),
            element: None,
        })
    }
    fn serialize_tuple(self, length: usize) -> Result<Elements, Unused> {
        Ok(Elements {
            length: length.to_string(),
            element: None,
        })
    }
    fn serialize_tuple_struct(
        self,
        name: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleStruct, Unused> {
        Err(Unused(name.to_owned()))
    }
    fn serialize_tuple_variant(
        self,
        name: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, Unused> {
        Err(Unused(name.to_owned()))
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, Unused> {
        Err(Unused("a map".to_owned()))
    }
    fn serialize_struct(self, name: &'static str, _: usize) -> Result<Shape, Unused> {
        Ok(Shape::scalar(name))
    }
    fn serialize_struct_variant(
        self,
        name: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, Unused> {
        Err(Unused(name.to_owned()))
    }
}

/// A sequence or array: the type of its first element.
struct Elements {
    length: String,
    element: Option<String>,
}

impl Elements {
    fn take<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Unused> {
        let kind = value.serialize(TypeOf)?.kind;
        self.element.get_or_insert(kind);
        Ok(())
    }
    fn finish(self) -> Result<Shape, Unused> {
        let element = self
            .element
            .ok_or_else(|| Unused("an empty sequence has no type".to_owned()))?;
        Ok(Shape::scalar(format!("{element}[{}]", self.length)))
    }
}

impl SerializeSeq for Elements {
    type Ok = Shape;
    type Error = Unused;
    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Unused> {
        self.take(value)
    }
    fn end(self) -> Result<Shape, Unused> {
        self.finish()
    }
}

impl SerializeTuple for Elements {
    type Ok = Shape;
    type Error = Unused;
    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Unused> {
        self.take(value)
    }
    fn end(self) -> Result<Shape, Unused> {
        self.finish()
    }
}

impl SerializeStruct for Shape {
    type Ok = Self;
    type Error = Unused;
    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Result<(), Unused> {
        self.fields
            .push((value.serialize(TypeOf)?.kind, name.to_owned()));
        Ok(())
    }
    fn end(self) -> Result<Self, Unused> {
        Ok(self)
    }
}

#[test]
fn our_messages_are_those_of_the_msg_files() {
    assert_eq!(
        written(&RingCentre::default()),
        declared(include_str!("../../../msg/RingCentre.msg"))
    );
    let array = RingCentreArray {
        centres: vec![RingCentre::default()],
        ..Default::default()
    };
    assert_eq!(
        written(&array),
        declared(include_str!("../../../msg/RingCentreArray.msg"))
    );
    assert_eq!(
        written(&CalibrationStatus::default()),
        declared(include_str!("../../../msg/CalibrationStatus.msg"))
    );
}

#[test]
fn ros_s_messages_are_those_of_ros() {
    let header = "builtin_interfaces/Time stamp\nstring frame_id";
    assert_eq!(written(&Header::default()), declared(header));
    assert_eq!(
        written(&Time::default()),
        declared("int32 sec\nuint32 nanosec")
    );
    let image = "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n\
                 uint8 is_bigendian\nuint32 step\nuint8[] data";
    assert_eq!(written(&Image::default()), declared(image));
    let compressed = "std_msgs/Header header\nstring format\nuint8[] data";
    assert_eq!(written(&CompressedImage::default()), declared(compressed));
    let roi = "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify";
    assert_eq!(written(&RegionOfInterest::default()), declared(roi));
    let camera_info = "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n\
                       float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\n\
                       uint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi";
    let info = CameraInfo {
        d: vec![0.0],
        ..Default::default()
    };
    assert_eq!(written(&info), declared(camera_info));
    let response = "bool success\nstring message";
    assert_eq!(written(&TriggerResponse::default()), declared(response));
    // rosidl puts this field into structures that have none
    assert_eq!(
        written(&TriggerRequest::default()),
        declared("uint8 structure_needs_at_least_one_member")
    );
}
