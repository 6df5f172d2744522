use super::*;
use proptest::prelude::*;

fn raw(width: u32, height: u32, encoding: &str, step: u32, data: Vec<u8>) -> RawImage {
    RawImage {
        width,
        height,
        encoding: encoding.into(),
        is_bigendian: false,
        step,
        data,
    }
}

fn pixels(image: RawImage) -> Pixels {
    image.into_frame(Stamp::default(), "cam").unwrap().pixels
}

/// The rows with `padding` bytes of rubbish after each.
fn padded(packed: &RawImage, padding: u32) -> RawImage {
    let mut data = Vec::new();
    for row in packed.data.chunks(packed.step as usize) {
        data.extend_from_slice(row);
        data.extend((0..padding).map(|k| 0xA5 ^ k as u8));
    }
    RawImage {
        step: packed.step + padding,
        data,
        ..packed.clone()
    }
}

fn random_picture(pixel_bytes: u32) -> impl Strategy<Value = (u32, u32, Vec<u8>)> {
    (1_u32..20, 1_u32..12).prop_flat_map(move |(width, height)| {
        let length = (width * height * pixel_bytes) as usize;
        proptest::collection::vec(any::<u8>(), length).prop_map(move |data| (width, height, data))
    })
}

proptest! {
    #[test]
    fn padding_means_nothing(
        (width, height, data) in random_picture(12), padding in 1_u32..9,
    ) {
        for (encoding, layout) in LAYOUTS {
            let bytes = layout.pixel_bytes();
            let data = data[..(width * height) as usize * bytes].to_vec();
            let packed = raw(width, height, encoding, width * bytes as u32, data);
            prop_assert_eq!(pixels(padded(&packed, padding)), pixels(packed));
        }
    }

    #[test]
    fn byte_order_is_a_promise_and_not_a_property((width, height, data) in random_picture(2)) {
        let little = raw(width, height, "mono16", 2 * width, data.clone());
        let swapped: Vec<u8> = data.chunks(2).flat_map(|p| [p[1], p[0]]).collect();
        let big = RawImage { is_bigendian: true, data: swapped, ..little.clone() };
        let same = RawImage { encoding: "16UC1".into(), ..little.clone() };
        let expected: Vec<u16> =
            data.chunks(2).map(|p| u16::from(p[0]) + 256 * u16::from(p[1])).collect();
        let plane = Plane::from_vec(width as usize, height as usize, expected).unwrap();
        let expected = Pixels::U16(plane);
        prop_assert_eq!(&pixels(little), &expected);
        prop_assert_eq!(&pixels(big), &expected);
        prop_assert_eq!(&pixels(same), &expected);
    }

    #[test]
    fn channel_orders_agree((width, height, rgb) in random_picture(3), alpha: u8) {
        let each = |order: &[usize], alpha: Option<u8>| -> Vec<u8> {
            rgb.chunks(3)
                .flat_map(|p| order.iter().map(|&k| p[k]).chain(alpha).collect::<Vec<_>>())
                .collect()
        };
        let expected = pixels(raw(width, height, "rgb8", 3 * width, rgb.clone()));
        let bgr = raw(width, height, "bgr8", 3 * width, each(&[2, 1, 0], None));
        let rgba = raw(width, height, "rgba8", 4 * width, each(&[0, 1, 2], Some(alpha)));
        let bgra = raw(width, height, "bgra8", 4 * width, each(&[2, 1, 0], Some(alpha)));
        prop_assert_eq!(&pixels(bgr), &expected);
        prop_assert_eq!(&pixels(rgba), &expected);
        prop_assert_eq!(&pixels(bgra), &expected);
    }

    #[test]
    fn no_header_makes_it_panic(
        width: u32, height: u32, step: u32, data: Vec<u8>, big: bool, layout in 0..LAYOUTS.len(),
    ) {
        let image = RawImage {
            is_bigendian: big,
            ..raw(width, height, LAYOUTS[layout].0, step, data)
        };
        let _ = image.into_frame(Stamp::default(), "");
    }
}

#[test]
fn colour_is_weighed_and_alpha_is_not() {
    let frame = pixels(raw(2, 1, "bgra8", 8, vec![0, 0, 255, 0, 255, 0, 0, 9]));
    assert_eq!(
        frame,
        Pixels::U8(Plane::from_vec(2, 1, vec![76, 29]).unwrap())
    );
}

#[test]
fn packed_grey_is_moved_and_not_copied() {
    let data = vec![7; 6];
    let address = data.as_ptr();
    let Pixels::U8(plane) = pixels(raw(3, 2, "mono8", 3, data)) else {
        panic!("mono8 is 8 bit");
    };
    assert_eq!(plane.data().as_ptr(), address);
}

#[test]
fn stamp_and_frame_id_are_kept() {
    let stamp = Stamp {
        sec: 3,
        nanosec: 14,
    };
    let frame = raw(1, 1, "8UC1", 1, vec![5])
        .into_frame(stamp, "left")
        .unwrap();
    assert_eq!((frame.stamp, frame.source.as_str()), (stamp, "left"));
}

#[test]
fn refusals_name_the_encoding_or_the_two_numbers() {
    let refused = |image: RawImage| {
        let error = image.into_frame(Stamp::default(), "").unwrap_err();
        error.to_string()
    };
    let bayer = refused(raw(2, 2, "bayer_rggb8", 2, vec![0; 4]));
    assert!(
        bayer.contains("\"bayer_rggb8\"") && bayer.contains("mono16"),
        "{bayer}"
    );
    let narrow = refused(raw(5, 2, "rgb8", 14, vec![0; 28]));
    assert!(narrow.contains("14") && narrow.contains("15"), "{narrow}");
    let short = refused(raw(4, 3, "mono8", 4, vec![0; 11]));
    assert!(short.contains("11") && short.contains("12"), "{short}");
    let long = refused(raw(4, 3, "mono8", 4, vec![0; 13]));
    assert!(long.contains("13") && long.contains("12"), "{long}");
    let unpadded_end = refused(raw(4, 3, "mono8", 6, vec![0; 16]));
    assert!(
        unpadded_end.contains("16") && unpadded_end.contains("18"),
        "{unpadded_end}"
    );
    assert!(refused(raw(0, 3, "mono8", 4, vec![])).contains("0 x 3"));
    assert!(refused(raw(3, 0, "mono8", 4, vec![])).contains("3 x 0"));
}

#[test]
fn huge_sizes_do_not_wrap_around() {
    // width * 4 and step * height both exceed 32 bits; wrapped around they would be 0
    let wide = raw(1 << 30, 1, "bgra8", 0, vec![]);
    assert!(matches!(
        wide.into_frame(Stamp::default(), ""),
        Err(FrameError::StepTooSmall { row_bytes, .. }) if row_bytes == 1 << 32
    ));
    let tall = raw(1, 1 << 31, "mono8", 2, vec![]);
    assert!(matches!(
        tall.into_frame(Stamp::default(), ""),
        Err(FrameError::DataLength { expected, .. }) if expected == 1 << 32
    ));
}
