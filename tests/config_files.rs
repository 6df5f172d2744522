//! The files of `config/` are what they say they are.

use ringcal::board::Board;
use std::path::Path;

fn board(name: &str) -> Board {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("config")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    Board::from_yaml(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Width and height that the rings cover, m.
fn extent_m(board: &Board) -> [f64; 2] {
    [board.columns(), board.rows()]
        .map(|count| f64::from(count - 1) * board.pitch_m() + 2.0 * board.outer_radius_m())
}

#[test]
fn the_paper_s_targets_are_those_of_its_table_1() {
    let table_mm = [
        ("paper_c1.yaml", 700.0, 100.0, 15.0, 30.0),
        ("paper_c2.yaml", 376.0, 53.7, 8.0, 16.0),
        ("paper_c3.yaml", 282.0, 40.3, 5.0, 10.0),
        ("paper_c4.yaml", 188.0, 26.9, 3.0, 6.0),
    ];
    for (name, size, pitch, inner, outer) in table_mm {
        let board = board(name);
        assert_eq!((board.rows(), board.columns()), (7, 7), "{name}");
        let lengths = [
            (board.pitch_m(), pitch),
            (board.inner_radius_m(), inner),
            (board.outer_radius_m(), outer),
        ];
        for (metres, millimetres) in lengths {
            assert!((metres - 1e-3 * millimetres).abs() < 1e-12, "{name}");
        }
        assert!(extent_m(&board)[0] < 1e-3 * size, "{name}");
    }
}

#[test]
fn the_a4_board_fits_the_sheet_with_margins_any_printer_can_keep() {
    let board = board("a4.yaml");
    let margin_m = 0.015;
    let [width, height] = extent_m(&board);
    assert!(width < 0.297 - 2.0 * margin_m && height < 0.210 - 2.0 * margin_m);
    assert_ne!(board.rows(), board.columns());
}
