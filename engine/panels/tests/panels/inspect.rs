//! Texels, their writers, and pictures that are compared.

use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{Compare, CompareMode, Figures, Looking, Map, PassWriters, TexelWriter};
use raxel_panels::{Action, Panel};
use raxel_picture::{NotFinite, Sought};

use crate::click;
use crate::window::{Window, inspected};

#[test]
fn a_texel_and_the_numbers_of_a_channel_are_read() {
    let mut window = Window::new(&[Panel::Inspect]);
    window.inspected = Some(inspected());
    let mut harness = window.harness(1280.0, 720.0);
    for said in [
        "NaN in r",
        "infinite in r",
        "NaN in g",
        "2",
        "texel 3, 4",
        "pinned",
        "0x7e00",
        "0x3400",
        "count u32",
        "42",
        "used u32",
        "6",
    ] {
        assert!(harness.query_all_by_label(said).next().is_some(), "{said}");
    }
    // A count of nothing is no button, and only the chosen channel has counts.
    assert!(harness.query_by_label("infinite in g").is_none());
    let find = |sought, channel, forward| [Action::Find { sought, channel, forward }];
    assert_eq!(click(&mut harness, "next NaN in g"), find(Sought::Nan, 1, true));
    assert_eq!(click(&mut harness, "previous infinite in r"), find(Sought::Infinite, 0, false));
    assert_eq!(click(&mut harness, "next largest in r"), find(Sought::Largest, 0, true));
    assert_eq!(click(&mut harness, "pin 1"), [Action::ChoosePin(1)]);
    assert_eq!(click(&mut harness, "Unpin"), [Action::Unpin(2)]);
    let inspected = harness.state_mut().inspected.as_mut().unwrap();
    inspected.not_finite = vec![NotFinite::default(); 2];
    inspected.looking = Some(Looking { sought: Sought::Nan, looked: 3, slices: 64 });
    (inspected.pins, inspected.pinned) = (Vec::new(), None);
    harness.run_steps(2);
    assert!(harness.query_by_label("looking for NaN: slice 3 of 64").is_some());
    assert_eq!(click(&mut harness, "Stop"), [Action::StopFind]);
    // There is none in this slice, and may be one in another.
    assert_eq!(click(&mut harness, "next NaN in r"), find(Sought::Nan, 0, true));
    assert_eq!(click(&mut harness, "Pin a texel"), [Action::Pin([3, 4])]);
    let own = Map { map: 0, range: None, channel: 0 };
    assert_eq!(click(&mut harness, "own map"), [Action::Display(Some(own))]);
    assert_eq!(click(&mut harness, "CSV"), [Action::WriteTable]);
}

/// The writers of the pinned texel are asked for by a button, and each line opens in the editor.
#[test]
fn the_writers_of_the_pinned_texel_are_listed() {
    let mut window = Window::new(&[Panel::Inspect]);
    window.inspected = Some(inspected());
    let mut harness = window.harness(1280.0, 20_000.0);
    assert!(harness.query_by_label("(9, 1, 0)").is_none());
    assert_eq!(click(&mut harness, "Who wrote it"), [Action::FindWriters(true)]);
    let none = "No pass that may write it has run with these shaders.";
    harness.state_mut().inspected.as_mut().unwrap().writers = Some(Vec::new());
    harness.run_steps(2);
    assert!(harness.query_by_label(none).is_some());
    let place = "shaders/shade.comp:41";
    let write = |invocation| TexelWriter {
        place: Some(place.to_owned()),
        invocation,
        workgroup: [1, 0, 0],
        values: vec!["0.5".to_owned(), "7".to_owned()],
    };
    let pass =
        |pass: &str, count, writes| PassWriters { pass: pass.to_owned(), frame: 12, count, race: count > 1, writes };
    harness.state_mut().inspected.as_mut().unwrap().writers = Some(vec![
        pass("clear", 0, Vec::new()),
        pass("shade", 1, vec![write([9, 1, 0])]),
        pass("sum", 300, vec![TexelWriter { place: None, ..write([3, 4, 5]) }; 256]),
    ]);
    harness.run_steps(2);
    let race = "Several invocations wrote it: without a barrier between them, the device decides which value is left.";
    for said in ["did not write it in frame 12", "in frame 12", "300 times in frame 12", race, "(9, 1, 0)", "0.5  7"] {
        assert!(harness.query_all_by_label(said).next().is_some(), "{said}");
    }
    assert!(harness.query_by_label("and 288 more").is_some() && harness.query_by_label(none).is_none());
    assert_eq!(harness.query_all_by_label("(3, 4, 5)").count(), 12);
    assert_eq!(click(&mut harness, place), [Action::Copy(place.to_owned())]);
    assert_eq!(click(&mut harness, "edit"), [Action::Edit(place.to_owned())]);
    assert_eq!(click(&mut harness, "Who wrote it"), [Action::FindWriters(false)]);
}

#[test]
fn a_kept_picture_is_compared_in_the_ways_that_are_asked_for() {
    let mut harness = Window::new(&[Panel::Compare]).harness(1280.0, 720.0);
    harness.get_by_label("Nothing is kept yet.");
    assert_eq!(click(&mut harness, "Keep"), [Action::Keep]);
    let kept = Some("color, generation 3, 320 × 180".to_owned());
    harness.state_mut().compare = Compare { kept, mode: CompareMode::Wipe, ..Compare::default() };
    harness.run_steps(2);
    harness.get_by_label("color, generation 3, 320 × 180");
    assert_eq!(click(&mut harness, "difference"), [Action::CompareMode(CompareMode::Difference)]);
    assert_eq!(click(&mut harness, "kept picture"), [Action::Flip]);
    assert_eq!(click(&mut harness, "Measure"), [Action::Measure]);
    harness.state_mut().compare.figures = Figures::Found {
        of: "color, generation 4".to_owned(),
        flip: 0.5,
        rmse: 0.25,
        max: 2.0,
        differing: [1234, 57_600],
    };
    harness.run_steps(2);
    for said in ["0.500000", "0.250000", "2.000000", "1,234 of 57,600"] {
        harness.get_by_label(said);
    }
    // A live target is measured while it is shown.
    harness.state_mut().compare.live = true;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Measure"), [Action::Measure]);
    harness.state_mut().compare.mode = CompareMode::Off;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Measure"), []);
    harness.state_mut().compare.mode = CompareMode::Wipe;
    // A target that cannot be compared has a message, and no figures.
    harness.state_mut().compare.refused = Some("the shown target is 4×4, the kept picture 8×8".to_owned());
    harness.run_steps(2);
    harness.get_by_label("the shown target is 4×4, the kept picture 8×8");
    assert_eq!(click(&mut harness, "Measure"), []);
    assert_eq!(click(&mut harness, "×"), [Action::ForgetKept]);
}

#[test]
fn a_picture_is_loaded_from_a_file_that_was_named() {
    let mut harness = Window::new(&[Panel::Compare]).harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "Load"), [], "no file is named");
    let field = harness.get_by_role(egui::accesskit::Role::TextInput);
    field.focus();
    field.type_text(" shots/a.png ");
    harness.run_steps(3);
    assert_eq!(click(&mut harness, "Load"), [Action::KeepFile("shots/a.png".to_owned())]);
}
