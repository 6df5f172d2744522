//! The order in which people number files: digits compare as numbers.

use std::cmp::Ordering;

/// Compares two names piece by piece: runs of digits by their value (however long), anything else by its characters.
pub(super) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        if a.is_empty() || b.is_empty() {
            return a.len().cmp(&b.len());
        }
        let (piece_a, rest_a) = first_piece(a);
        let (piece_b, rest_b) = first_piece(b);
        let order = compare_pieces(piece_a, piece_b);
        if order.is_ne() {
            return order;
        }
        (a, b) = (rest_a, rest_b);
    }
}

/// A run of digits or a run of anything else, and what follows.
fn first_piece(text: &str) -> (&str, &str) {
    let digits = text.starts_with(|c: char| c.is_ascii_digit());
    let end = text.find(|c: char| c.is_ascii_digit() != digits);
    text.split_at(end.unwrap_or(text.len()))
}

fn compare_pieces(a: &str, b: &str) -> Ordering {
    let is_number = |piece: &str| piece.starts_with(|c: char| c.is_ascii_digit());
    if is_number(a) && is_number(b) {
        // without leading zeros the longer number is the larger, and equal lengths compare as text
        let (a, b) = (a.trim_start_matches('0'), b.trim_start_matches('0'));
        a.len().cmp(&b.len()).then_with(|| a.cmp(b))
    } else {
        a.cmp(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_count() {
        let mut names = [
            "v10.png",
            "v9b.png",
            "v9.png",
            "u",
            "v",
            "v0010a",
            "7",
            "v99999999999999999999999",
            "v2.png",
        ];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(
            names,
            [
                "7",
                "u",
                "v",
                "v2.png",
                "v9.png",
                "v9b.png",
                "v10.png",
                "v0010a",
                "v99999999999999999999999"
            ]
        );
    }

    proptest! {
        #[test]
        fn is_an_order(a in "[a-b0-2]{0,5}", b in "[a-b0-2]{0,5}", c in "[a-b0-2]{0,5}") {
            prop_assert_eq!(natural_order(&a, &b), natural_order(&b, &a).reverse());
            if natural_order(&a, &b).is_le() && natural_order(&b, &c).is_le() {
                prop_assert!(natural_order(&a, &c).is_le());
            }
        }
    }
}
