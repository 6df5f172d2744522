use super::*;
use crate::calibrate::{
    CalibrateError, CalibrateOptions, Facts, Fixed, FramesRead, assess, calibrate, cross_validate,
    refused, synthetic,
};
use crate::frame::{Frame, Plane};
use crate::report::Picture;

const SIGMA_PX: f64 = 0.02;

/// Views of a board at these poses of the ordinary camera, noise as the rings say.
fn views(poses: &[crate::camera::Pose]) -> Vec<View> {
    noisy_views(poses, SIGMA_PX)
}

fn noisy_views(poses: &[crate::camera::Pose], sigma_px: f64) -> Vec<View> {
    let (camera, board) = (synthetic::ordinary(), synthetic::board());
    let mut views = synthetic::views(&camera, &board, poses, sigma_px, 1);
    synthetic::with_covariance(&mut views, nalgebra::Matrix2::identity() * sigma_px.powi(2));
    views
}

/// Boards all over the frame.
fn all_over() -> Vec<crate::camera::Pose> {
    let (camera, board) = (synthetic::ordinary(), synthetic::board());
    let pose = |i: u32| {
        let (x, y, a) = (f64::from(i % 4), f64::from(i / 4), f64::from(i) * 2.4);
        let pixel = [1280.0 * (0.2 + 0.2 * x), 960.0 * (0.22 + 0.187 * y)];
        synthetic::pose_at(
            &camera,
            &board,
            pixel,
            0.45,
            [0.5 * a.cos(), 0.5 * a.sin(), 0.0],
        )
    };
    (0..16).map(pose).collect()
}

struct Case {
    views: Vec<View>,
    outcomes: Vec<Outcome>,
    passed_over: Vec<(u64, String)>,
    pictures: Pictures,
    options: CalibrateOptions,
}

impl Case {
    fn new(views: Vec<View>) -> Self {
        let grey = Frame::from_u8(Plane::filled(1280, 960, 90), "");
        let picture =
            |view: &View| Some((view.source.clone(), Picture::of(&Picture::reduce(&grey))?));
        Self {
            outcomes: (0..views.len()).map(Outcome::Used).collect(),
            passed_over: Vec::new(),
            pictures: views.iter().filter_map(picture).collect(),
            options: CalibrateOptions::default(),
            views,
        }
    }

    /// The page as the command line makes it.
    fn page(&self) -> String {
        let board = synthetic::board();
        match calibrate(&board, &self.views, &self.options) {
            Ok(calibration) => {
                let validated = cross_validate(&board, &self.views, &self.options, &calibration);
                let assessment = assess(&Facts::of(&calibration, &self.views, validated.as_ref()));
                let solved = Solved {
                    calibration: &calibration,
                    validated: validated.as_ref().ok(),
                };
                report_html(&self.report(&board, &assessment, Some(solved)))
            }
            Err(error) => report_html(&self.report(&board, &self.refusal(&error), None)),
        }
    }

    fn refusal(&self, error: &CalibrateError) -> Assessment {
        let frames = FramesRead {
            all: self.outcomes.len() as u64,
            with_board: self.views.len() as u64,
            moving: 0,
        };
        refused(error, frames)
    }

    fn report<'a>(
        &'a self,
        board: &'a Board,
        assessment: &'a Assessment,
        solved: Option<Solved<'a>>,
    ) -> Report<'a> {
        Report {
            camera_name: "<b>",
            estimator: "photometric",
            board,
            inputs: self.outcomes.len() as u64,
            views: &self.views,
            outcomes: &self.outcomes,
            passed_over: &self.passed_over,
            pictures: &self.pictures,
            assessment,
            solved,
        }
    }
}

/// The text of the sentence below the word.
fn sentence(page: &str) -> &str {
    let (_, rest) = page.split_once("<p class=\"sentence\">").unwrap();
    rest.split_once("</p>").unwrap().0
}

fn word_is(page: &str, word: &str) -> bool {
    page.contains(&format!("</svg>{word}</p>\n<p class=\"sentence\">"))
}

fn balanced(page: &str) {
    for tag in [
        "svg",
        "table",
        "figure",
        "g",
        "tr",
        "td",
        "ul",
        "section",
        "dl",
        "text",
        "figcaption",
    ] {
        let opened =
            page.matches(&format!("<{tag} ")).count() + page.matches(&format!("<{tag}>")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

#[test]
fn a_good_calibration_says_so_first() {
    let page = Case::new(views(&all_over())).page();
    assert!(word_is(&page, "Good"), "{}", sentence(&page));
    assert_eq!(
        sentence(&page),
        "Directions are known to 0.077 px (one standard deviation) everywhere in the frame; the rings of 16 views \
         cover 100 % of it."
    );
    assert_eq!(page.matches("class=\"grade good\"").count(), 7);
    assert!(!page.contains("What to do"));
    assert!(page.contains("<p id=\"left-out\">Nothing.</p>"));
    balanced(&page);
}

#[test]
fn a_poor_one_says_what_it_lacks_and_what_to_do() {
    let poses = synthetic::poses(&synthetic::ordinary(), &synthetic::board());
    let page = Case::new(noisy_views(&poses[..7], 0.1)).page();
    assert!(word_is(&page, "Usable"), "{}", sentence(&page));
    assert_eq!(
        sentence(&page),
        "Near pixel (1216, 912) directions are known to 0.456 px only (good: at most 0.1 px); \
         7 views took part (good: at least 10)."
    );
    assert!(page.contains("What to do"));
    balanced(&page);
}

#[test]
fn a_refused_one_says_why_and_shows_what_was_seen() {
    let (camera, board) = (synthetic::ordinary(), synthetic::board());
    let upright = |x: f64| synthetic::pose_at(&camera, &board, [x, 480.0], 0.5, [0.3, 0.0, 0.0]);
    let mut case = Case::new(views(&[400.0, 600.0, 700.0, 900.0].map(upright)));
    case.passed_over = vec![(12, "without the board".to_owned())];
    let page = case.page();
    assert!(word_is(&page, "Not enough"), "{}", sentence(&page));
    assert_eq!(
        sentence(&page),
        "No calibration was made. The board stands at the same tilt in all views (within 0.0 degrees): tilt it by 20 \
         degrees or more about both axes."
    );
    assert!(page.contains("No camera_info.yaml was written"));
    assert!(page.contains("<td class=\"source\">12 frames of bags</td><td>without the board</td>"));
    assert!(!page.contains("id=\"parameters\"") && !page.contains("id=\"criteria\""));
    assert_eq!(page.matches("<figure>").count(), 2 + 4);
    balanced(&page);
}

#[test]
fn everything_is_there_and_what_comes_from_outside_is_escaped() {
    let mut case = Case::new(views(&all_over()));
    case.options.fixed = Fixed::from_entries(["k3"]).unwrap();
    case.outcomes.push(Outcome::NotUsed {
        source: "<script>.png".into(),
        reason: "\"a\" & 'b'".into(),
    });
    // the worst view, and one that is another board's
    for ring in &mut case.views[3].rings {
        ring.centre.point.x += 0.05 * f64::from(i32::from(ring.row) % 2);
    }
    for ring in &mut case.views[5].rings {
        ring.centre.point.x += 40.0 * f64::from((3 * ring.row + 5 * ring.column) % 4);
    }
    let page = case.page();
    assert!(!page.contains("<script") && !page.contains("<b>,") && !page.contains("of <b>"));
    assert!(page.contains(
        "<td class=\"source\">&lt;script&gt;.png</td><td>&quot;a&quot; &amp; &#39;b&#39;</td>"
    ));
    assert!(page.contains("15 used of 17 inputs"), "{page}");
    assert!(page.contains("<td>k3</td><td class=\"n\">0.00000000</td><td class=\"n\">fixed</td>"));
    assert!(
        page.contains("view 6, view 5</td><td>"),
        "the view that was left out"
    );
    // eight figures and twelve of sixteen views: that which was left out, then the worst
    assert_eq!(page.matches("<figure>").count(), 8 + 12);
    let order: Vec<&str> = page
        .split("<figcaption><b>")
        .skip(1)
        .map(|rest| rest.split_once("</b>").unwrap().0)
        .collect();
    assert_eq!((order.len(), &order[..2]), (12, &["View 6", "View 4"][..]));
    assert_eq!(page.matches("<td class=\"source\">view ").count(), 1 + 16);
    balanced(&page);
}

#[test]
fn it_needs_nothing_from_elsewhere_and_is_the_same_every_time() {
    let case = Case::new(views(&all_over()));
    let page = case.page();
    for link in [
        "http:", "https:", "//", "src=", "@import", "<link", "<script",
    ] {
        assert!(
            !page.contains(link) || link == "//" && only_in_data(&page),
            "{link}"
        );
    }
    assert_eq!(page, case.page());
}

/// Base 64 has slashes, too.
fn only_in_data(page: &str) -> bool {
    page.match_indices("//").all(|(at, _)| {
        let before = &page[..at];
        before
            .rfind("base64,")
            .is_some_and(|data| !before[data..].contains('"'))
    })
}

#[test]
fn two_hundred_views_stay_below_two_megabytes() {
    let poses: Vec<_> = (0..13).flat_map(|_| all_over()).take(200).collect();
    let mut many = views(&poses);
    let board = synthetic::board();
    // one calibration of a part stands for all: what counts is the size of the page
    let calibration = calibrate(&board, &many[..16], &CalibrateOptions::default()).unwrap();
    let mut all = calibration.clone();
    all.views = calibration
        .views
        .iter()
        .cycle()
        .take(200)
        .cloned()
        .collect();
    for (at, view) in many.iter_mut().enumerate() {
        view.source = format!("a/folder/with/a/long/name/view_{at:05}.png");
    }
    let case = Case::new(many);
    let assessment = case.refusal(&CalibrateError::TooFewViews { found: 0 });
    let solved = Solved {
        calibration: &all,
        validated: None,
    };
    let page = report_html(&case.report(&board, &assessment, Some(solved)));
    assert!(page.len() < 2_000_000, "{}", page.len());
    assert!(page.contains("12 of the 200 views"));
}
