//! Laws of every sheet.

use super::*;
use crate::board::{Board, Polarity};
use proptest::prelude::*;

fn options(stock: Stock) -> PrintOptions {
    PrintOptions {
        name: "a board".to_owned(),
        stock,
        quiet_mm: None,
        margin_mm: 5.0,
    }
}

/// Boards of all shapes, some with marks in a corner.
fn boards() -> impl Strategy<Value = Board> {
    let sizes = prop_oneof![Just((1, 1)), (2..=16_u16, 2..=16_u16)];
    let lengths = (1.2e-3..0.05_f64, 0.1..0.9_f64, 2.05..5.0_f64);
    (sizes, lengths, any::<bool>(), any::<bool>()).prop_map(
        |((rows, columns), (outer, ratio, pitch), light, marked)| {
            let polarity = match light {
                true => Polarity::LightOnDark,
                false => Polarity::DarkOnLight,
            };
            let (pitch, inner) = (pitch * outer, ratio * outer);
            let board = Board::new(rows, columns, pitch, inner, outer, polarity).unwrap();
            match marked && rows * columns >= 12 {
                true => board.with_marks(vec![(0, 0), (0, 1), (1, 0)]).unwrap(),
                false => board,
            }
        },
    )
}

fn stocks() -> impl Strategy<Value = Stock> {
    let paper = |text: &str| Stock::Sheet(text.parse().unwrap());
    prop_oneof![
        Just(Stock::Smallest),
        (80.0..3000.0_f64).prop_map(|width_mm| Stock::Roll { width_mm }),
        Just(paper("5000x3000")),
        (60.0..500.0_f64, 60.0..500.0_f64)
            .prop_map(move |(width, height)| paper(&format!("{width}x{height}"))),
    ]
}

/// Checks what holds for every sheet of this board.
fn check(board: &Board, sheet: &Sheet, margin_mm: f64) -> Result<(), TestCaseError> {
    let page = Area::at(
        [margin_mm; 2],
        sheet.width_mm - 2.0 * margin_mm,
        sheet.height_mm - 2.0 * margin_mm,
    );
    prop_assert!(page.contains(&sheet.field), "field {:?}", sheet.field);
    let rings: Vec<_> = sheet
        .shapes
        .iter()
        .filter(|s| matches!(s, Shape::Ring { .. }))
        .collect();
    prop_assert_eq!(rings.len(), board.ring_count());
    let first = rings[0].area();
    for ((row, column), ring) in board.indices().zip(&rings) {
        let Shape::Ring { inner_mm, .. } = ring else {
            unreachable!()
        };
        prop_assert_eq!(inner_mm.is_none(), board.is_mark(row, column));
        let [x, y] = board.centre_m(row, column);
        let off = [
            ring.area().low_mm[0] - first.low_mm[0] - 1e3 * x,
            ring.area().low_mm[1] - first.low_mm[1] - 1e3 * y,
        ];
        prop_assert!(
            off.iter().all(|v| v.abs() < 1e-9),
            "ring {row} {column}: {off:?}"
        );
        prop_assert!(sheet.field.contains(&ring.area()));
    }
    let others = sheet
        .shapes
        .iter()
        .map(Shape::area)
        .filter(|area| *area != sheet.field);
    let others: Vec<_> = others.filter(|area| !sheet.field.contains(area)).collect();
    let texts: Vec<_> = sheet.texts.iter().map(Text::area).collect();
    for (at, area) in texts.iter().chain(&others).enumerate() {
        let what = sheet.texts.get(at).map_or("a shape", |text| &text.text);
        prop_assert!(page.contains(area), "{what} beyond the margins: {area:?}");
        prop_assert!(!sheet.field.overlaps(area), "{what} in the quiet zone");
    }
    for (at, area) in texts.iter().enumerate() {
        let what = &sheet.texts[at].text;
        prop_assert!(
            others.iter().all(|other| !other.overlaps(area)),
            "{what} over a shape"
        );
        prop_assert!(
            texts[..at].iter().all(|other| !other.overlaps(area)),
            "{what} over a text"
        );
    }
    prop_assert_eq!(&Board::from_yaml(&sheet.yaml).unwrap(), board);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn everything_is_on_the_page_and_nothing_on_anything_else(board in boards(), stock in stocks(), margin_mm in 0.0..20.0_f64) {
        let options = PrintOptions { margin_mm, ..options(stock) };
        match lay_out(&board, &options) {
            Ok(sheet) => check(&board, &sheet, margin_mm)?,
            Err(refusal) => {
                let sentence = refusal.to_string();
                prop_assert!(sentence.contains("mm") && !sentence.contains("NaN"), "{sentence}");
            }
        }
    }

    #[test]
    fn a_paper_of_the_size_that_a_refusal_asks_for_holds_the_board(board in boards()) {
        let small = "40x40".parse().unwrap();
        if let Err(PrintError::DoesNotFit { needed_mm, .. }) = lay_out(&board, &options(Stock::Sheet(small))) {
            let paper = format!("{}x{}", needed_mm[0] + 0.1, needed_mm[1] + 0.1);
            if let Ok(paper) = paper.parse() {
                prop_assert!(lay_out(&board, &options(Stock::Sheet(paper))).is_ok());
            }
        }
    }
}

fn board(rows: u16, columns: u16, pitch_m: f64) -> Board {
    let (inner, outer) = (0.006, 0.012);
    Board::new(rows, columns, pitch_m, inner, outer, Polarity::DarkOnLight).unwrap()
}

#[test]
fn the_smallest_paper_that_holds_the_board_is_taken_the_way_it_fits() {
    let size = |board: &Board| {
        let sheet = lay_out(board, &options(Stock::Smallest)).unwrap();
        (sheet.paper, sheet.width_mm, sheet.height_mm)
    };
    assert_eq!(size(&board(5, 7, 0.038)), ("a4".to_owned(), 297.0, 210.0));
    assert_eq!(size(&board(7, 5, 0.038)), ("a4".to_owned(), 210.0, 297.0));
    assert_eq!(size(&board(7, 9, 0.038)), ("a3".to_owned(), 420.0, 297.0));
    let roll = Stock::Roll { width_mm: 1200.0 };
    let sheet = lay_out(&board(9, 40, 0.038), &options(roll)).unwrap();
    assert!(sheet.height_mm == 1200.0 && sheet.width_mm > 1500.0 || sheet.width_mm == 1200.0);
}

#[test]
fn what_does_not_fit_is_refused_with_the_sizes() {
    let say = |stock| {
        lay_out(&board(10, 10, 0.04), &options(stock))
            .unwrap_err()
            .to_string()
    };
    let sentence = say(Stock::Sheet("a4".parse().unwrap()));
    assert!(
        sentence.contains("398.4 x 398.4 mm") && sentence.contains("a4 has 2"),
        "{sentence}"
    );
    assert!(sentence.ends_with("--paper a2 holds it"), "{sentence}");
    let sentence = say(Stock::Roll { width_mm: 300.0 });
    assert!(
        sentence.contains("a roll at least") && sentence.contains("not 300 mm"),
        "{sentence}"
    );
    let long = Board::new(2, 100, 0.06, 0.01, 0.02, Polarity::Auto).unwrap();
    let roll = Stock::Roll { width_mm: 200.0 };
    let refusal = lay_out(&long, &options(roll)).unwrap_err().to_string();
    assert!(refusal.contains("at most 5000 mm long"), "{refusal}");
}

#[test]
fn the_rulers_count_from_the_first_ring_and_have_100_mm() {
    let sheet = lay_out(&board(5, 7, 0.038), &options(Stock::Smallest)).unwrap();
    let Shape::Ring { centre_mm, .. } = sheet.shapes[0] else {
        panic!("no ring")
    };
    let bars = sheet
        .shapes
        .iter()
        .filter(|shape| matches!(shape, Shape::Rectangle { .. }));
    let middles: Vec<f64> = bars
        .map(Shape::area)
        .filter(|bar| bar.width_mm() < bar.height_mm())
        .map(|bar| 0.5 * (bar.low_mm[0] + bar.high_mm[0]))
        .collect();
    assert_eq!(middles.len(), 231);
    assert!((middles[0] - centre_mm[0]).abs() < 1e-9);
    assert!((middles[100] - middles[0] - 100.0).abs() < 1e-9);
    assert!(
        sheet
            .texts
            .iter()
            .any(|t| t.text.starts_with("100 mm here must measure 100 mm"))
    );
}

#[test]
fn huge_pictures_are_refused_before_they_are_drawn() {
    let sheet = lay_out(&board(5, 7, 0.038), &options(Stock::Smallest)).unwrap();
    for dpi in [3000.0, 1e9, f64::INFINITY] {
        let sentence = png(&sheet, dpi).unwrap_err().to_string();
        assert!(sentence.contains("400 million"), "{sentence}");
    }
    for dpi in [1.0, 0.0, f64::NAN] {
        assert!(
            matches!(png(&sheet, dpi), Err(PrintError::TooCoarse { .. })),
            "{dpi}"
        );
    }
}

#[test]
fn a_picture_has_as_much_ink_as_the_rings_whatever_the_resolution() {
    let one = Board::new(1, 1, 0.0, 0.004, 0.011, Polarity::LightOnDark).unwrap();
    let sheet = lay_out(&one, &options(Stock::Smallest)).unwrap();
    for dpi in [61.0, 100.3, 150.0] {
        let picture = image::load_from_memory(&png(&sheet, dpi).unwrap())
            .unwrap()
            .into_luma8();
        let px_per_mm = 1e-3 * (dpi / 0.0254_f64).round();
        let middle = sheet.field.low_mm.map(|v| v + 0.5 * sheet.field.width_mm());
        // a window within the dark ground
        let half = 11.5;
        let (mut light, mut moment) = (0.0, [0.0; 2]);
        for (x, y, pixel) in picture.enumerate_pixels() {
            let at = [f64::from(x), f64::from(y)].map(|v| (v + 0.5) / px_per_mm);
            let off = [at[0] - middle[0], at[1] - middle[1]];
            if off[0].abs() < half && off[1].abs() < half {
                let grey = f64::from(pixel.0[0]) / 255.0 / (px_per_mm * px_per_mm);
                light += grey;
                moment = [moment[0] + off[0] * grey, moment[1] + off[1] * grey];
            }
        }
        let expected = std::f64::consts::PI * (11.0_f64.powi(2) - 4.0_f64.powi(2));
        assert!(
            (light / expected - 1.0).abs() < 1e-3,
            "{dpi}: {light} {expected}"
        );
        assert!(
            moment.iter().all(|m| (m / light).abs() < 1e-3),
            "{dpi}: {moment:?}"
        );
    }
}

#[test]
fn the_same_sheet_gives_the_same_bytes() {
    let sheet = || lay_out(&board(3, 4, 0.03), &options(Stock::Smallest)).unwrap();
    assert_eq!(pdf(&sheet()), pdf(&sheet()));
    assert_eq!(svg(&sheet()), svg(&sheet()));
    assert_eq!(png(&sheet(), 50.0).unwrap(), png(&sheet(), 50.0).unwrap());
}
