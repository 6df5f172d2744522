//! The head of the page: the verdict, why, and what to do; and the numbers behind it.

use super::Report;
use super::escape::escaped;
use crate::calibrate::{Assessment, Criterion, Grade};

/// The verdict.
pub(super) fn section(report: &Report) -> String {
    let Assessment {
        grade,
        reason,
        advice,
        ..
    } = report.assessment;
    let word = capitalised(grade.word());
    let reason = escaped(&capitalised(reason));
    let stop = if reason.ends_with('.') { "" } else { "." };
    let advice: String = advice
        .iter()
        .map(|line| format!("<li>{}</li>\n", escaped(line)))
        .collect();
    let advice = if advice.is_empty() {
        String::new()
    } else {
        format!("<p><b>What to do</b></p>\n<ul>\n{advice}</ul>\n")
    };
    format!(
        "<section id=\"verdict\" class=\"verdict {}\">\n<p class=\"word\">{}{word}</p>\n\
         <p class=\"sentence\">{reason}{stop}</p>\n{advice}<p>{}</p>\n</section>\n",
        class(*grade),
        sign(*grade),
        files(report),
    )
}

/// What the verdict means for the files beside the page.
fn files(report: &Report) -> &'static str {
    match (report.solved.is_some(), report.assessment.grade) {
        (false, _) => {
            "No camera_info.yaml was written; one that lies beside this page is of an earlier run."
        }
        (true, Grade::NotEnough) => {
            "camera_info.yaml was written all the same, to look at. Do not rely on it."
        }
        (true, _) => {
            "A page made from the same views as the calibration cannot see what all of them have wrong in common. Take some new \
             views, at another distance and in focus, and hold the calibration against them with <code>ringcal check</code>."
        }
    }
}

/// The table of the rules, each number beside its limits.
pub(super) fn criteria(assessment: &Assessment) -> String {
    if assessment.criteria.is_empty() {
        return String::new();
    }
    let rows: String = assessment.criteria.iter().map(row).collect();
    format!(
        "<h2>Why</h2>\n<p>The verdict is that of the worst line.</p>\n<div class=\"scroll\"><table \
         id=\"criteria\">\n<tr><th>What</th>\
         <th class=\"n\">Here</th><th></th><th class=\"n\">Good</th><th class=\"n\">Usable</th></tr>\n{rows}</table></div>\n"
    )
}

fn row(criterion: &Criterion) -> String {
    let rule = criterion.rule;
    let [good, usable] = rule.limits().map(|limit| rule.limit_short(limit));
    format!(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"grade {}\">{}</td>\
         <td class=\"n\">{good}</td><td class=\"n\">{usable}</td></tr>\n",
        rule.question(),
        criterion.text(),
        class(criterion.grade),
        criterion.grade,
    )
}

fn class(grade: Grade) -> &'static str {
    match grade {
        Grade::Good => "good",
        Grade::Usable => "usable",
        Grade::NotEnough => "poor",
    }
}

/// A shape beside the word, because not everybody tells the colours apart: a hook, an exclamation mark, a cross.
fn sign(grade: Grade) -> String {
    let lines = match grade {
        Grade::Good => "M7 12.5l3.5 3.5l6.5-8",
        Grade::Usable => "M12 6.5v7M12 17v.1",
        Grade::NotEnough => "M8 8l8 8M16 8l-8 8",
    };
    format!(
        "<svg viewBox=\"0 0 24 24\" aria-hidden=\"true\"><circle cx=\"12\" cy=\"12\" r=\"10.5\"/><path d=\"{lines}\"/></svg>"
    )
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(characters).collect()
    })
}
