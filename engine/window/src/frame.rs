//! One frame of the window: edits, motion, the picture, the panels over it, the title.

use std::time::{Duration, Instant};

use raxel_control::{Control, Next};
use raxel_execute::{ExecuteError, FrameReport, PassOutcome, Progress};
use raxel_output::shown;
use raxel_panels::view::{Busy, Compiling, Editing, FirstPicture, Status, World};
use raxel_panels::{Panel, View};
use raxel_runtime::camera::FlyInput;
use raxel_runtime::present::{Place, PresentError, Presented};
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::session::CaptureError;
use raxel_runtime::{FrameError, ReadError};
use raxel_terminal::console::To;
use raxel_terminal::failure::Result;
use raxel_terminal::session::frame_failure;
use raxel_workbench::demo;
use raxel_workbench::writes::follow_files;
use winit::event_loop::{ActiveEventLoop, ControlFlow};

use super::brush::Stroke;
use super::presenting::{Open, Pictures, refused};
use super::problem_log::{prints, problems};
use super::reload_log::{STARTED_OVER, history_cleared};
use super::{
    GROUND, Ground, LANDED, MEANWHILE, MENDED, NextFrame, PATIENCE, PATIENCE_AT_FIRST, Placed, REFRESH, SLICE, STILL,
    Viewer, brush, outline, panel_data, preset_list,
};

/// Whole seconds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a take has 0 to 600 seconds")]
fn whole(seconds: f64) -> u64 {
    seconds as u64
}

impl Open {
    /// Presents the picture that was taken from the other device last, with the panels where they are visible.
    fn present_taken(&mut self, visible: bool) -> std::result::Result<Presented, PresentError> {
        self.overlay.present(&mut self.presenter, |presenter, overlay| {
            presenter.present_taken(GROUND, visible.then_some(overlay))
        })
    }
}

impl Viewer<'_> {
    /// One frame. Never waits for the device for longer than a [`SLICE`]: events are handled in between, so that the window can be closed
    /// and an edit taken in while the device works.
    pub(super) fn draw(&mut self, event_loop: &ActiveEventLoop) -> Result {
        self.take_events()?;
        if self.answer_requests() == Next::Quit {
            event_loop.exit();
            return Ok(());
        }
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        if self.session.is_waiting() {
            return self.draw_mistakes(event_loop);
        }
        event_loop.set_control_flow(ControlFlow::Poll);
        // Threads that read or write files do not wait for the device.
        self.report_written();
        self.touched |= self.files.take();
        if self.window.is_none() {
            return Ok(());
        }
        self.greet(event_loop)?;
        let hidden = self.is_hidden();
        if self.unshown && !hidden && !self.show(event_loop)? {
            return self.draw_meanwhile(event_loop);
        }
        if let Some(at) = self.next_frame()
            && Instant::now() < at
        {
            // An answer that is awaited, and the end of a file, do not wait for the frame.
            let awaited = self.control.as_ref().is_some_and(Control::awaits) || self.writings.are_running();
            let next = if awaited { at.min(Instant::now() + STILL) } else { at };
            event_loop.set_control_flow(ControlFlow::WaitUntil(next));
            return Ok(());
        }
        // A program asks for the times of the last frame: they are there once it has ended.
        let holds = self.control.as_ref().is_some_and(Control::holds_frame);
        let progress = if holds { self.session.wait_picture(SLICE) } else { self.session.wait_next(SLICE) };
        if !self.is_done(progress)? {
            return self.draw_meanwhile(event_loop);
        }
        if holds {
            return Ok(());
        }
        demo::turn(&mut self.session, self.looped);
        self.fly();
        self.record_frame();
        let inspects =
            self.panels.layout.is_open(Panel::Inspect) || self.inspector.is_copying() || self.writes_values();
        let draws_graph = self.panels.are_drawn() && self.panels.layout.is_open(Panel::Graph);
        self.session.make_thumbnails(draws_graph);
        self.session.set_region(self.magnifier.region());
        if let Some(said) = self.comparing.update(&mut self.session) {
            self.notice(said);
        }
        if inspects {
            self.inspector.ask(&mut self.session);
        }
        self.long = [false, self.long[0]];
        let report = match self.next_report() {
            Ok(report) => report,
            // Reported once; the old plan runs on.
            Err(error @ FrameError::Plan { .. }) => {
                self.reloads.refused(&error);
                if let FrameError::Plan { diagnostics, texts } = &error {
                    self.problems = problems(diagnostics, texts);
                }
                self.titled = None;
                return Ok(());
            }
            Err(error) => return Err(frame_failure(error, self.console)),
        };
        self.look_at_log();
        let printed = self.session.take_prints();
        self.printed.say(&printed, self.console);
        let said = self.session.take_messages();
        self.console.diagnostics(&said, self.session.texts(), To::Stderr);
        if let Some(control) = &self.control {
            control.say(&said, self.session.texts());
            control.say_printed(&printed);
        }
        self.data.note(&mut self.session, &report);
        if draws_graph {
            self.touched |= self.data.take_thumbnails(&mut self.session);
        } else {
            self.data.drop_thumbnails();
        }
        if inspects {
            self.inspector.generation = self.reloads.shown;
            self.touched |= self.inspector.take(&mut self.session, &report);
            self.end_search();
            self.take_copies();
        } else {
            self.inspector.rest(&mut self.session);
        }
        if hidden {
            // It is drawn once it is seen.
            self.touched = true;
            return Ok(());
        }
        let still = !report.displayed && report.dispatched == 0;
        let due = self.window.as_ref().is_some_and(|open| open.overlay.is_due());
        // A picture that stands still is not drawn again and again for nothing.
        if still && !self.touched && !due && self.drawn.elapsed() < REFRESH && self.args.frames.is_none() {
            event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + STILL));
            return Ok(());
        }
        (self.touched, self.drawn) = (false, Instant::now());
        self.draw_panels(event_loop);
        self.unshown = true;
        if self.show(event_loop)? && still {
            event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + STILL));
        }
        Ok(())
    }

    /// Shows the panels over a plain ground until the first picture is there, which may take the driver seconds.
    fn greet(&mut self, event_loop: &ActiveEventLoop) -> Result {
        if std::mem::replace(&mut self.ground, Ground::Shown) == Ground::Shown {
            return Ok(());
        }
        self.draw_panels(event_loop);
        let visible = self.panels.are_drawn();
        let Some(Open { presenter, overlay, .. }) = &mut self.window else { return Ok(()) };
        let presented =
            overlay.present(presenter, |presenter, frame| presenter.present_blank(GROUND, visible.then_some(frame)));
        match presented {
            Ok(_) => Ok(()),
            // The next presentation finds the loss, too.
            Err(error) if error.is_device_lost() => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Runs a frame, captured if that was asked for.
    fn next_report(&mut self) -> std::result::Result<FrameReport, FrameError> {
        if std::mem::take(&mut self.next_runs) == NextFrame::Plain {
            return self.session.frame();
        }
        match self.session.capture_frame() {
            Ok((report, file)) => {
                self.console.message(&format!("wrote {}", shown(&file)));
                self.notice(format!("wrote {}", shown(&file)));
                Ok(report)
            }
            Err(CaptureError::Frame(error)) => Err(error),
            Err(error) => {
                self.warn(error.to_string());
                self.session.frame()
            }
        }
    }

    /// When the next frame may begin at the earliest, where the rate is bounded.
    fn next_frame(&self) -> Option<Instant> {
        let cap = self.fps_cap?;
        Some(self.last + Duration::from_secs(1) / cap.max(1))
    }

    /// Handles the events since files have changed.
    pub(super) fn take_events(&mut self) -> Result {
        self.session.poll_reload().into_iter().try_for_each(|event| self.note(event))
    }

    /// Notes an event of the files.
    fn note(&mut self, event: ReloadEvent) -> Result {
        self.reloads.tell(&event);
        if let Some(control) = &mut self.control {
            control.note(&event);
        }
        (self.titled, self.touched) = (None, true);
        match event {
            ReloadEvent::Reloaded(reloaded) => {
                self.problems = problems(&reloaded.diagnostics, &reloaded.texts);
                self.data.forget();
                if reloaded.opened {
                    self.begin_opened();
                }
                follow_files(&mut self.session, &mut self.written);
            }
            ReloadEvent::Failed(failed) => self.problems = problems(&failed.diagnostics, &failed.texts),
            ReloadEvent::HistoryCleared { size, resources } => self.notice(history_cleared(size, &resources)),
            // The name of a pass that is off stands beside it, for as long as it is off.
            ReloadEvent::DeviceRebuilt { .. } => self.notice(format!("the device was opened again; {STARTED_OVER}")),
            ReloadEvent::NotOpened(error) => return self.note_mistakes(error),
            ReloadEvent::Opened => return self.begin(),
        }
        Ok(())
    }

    /// Draws the panels over the next picture and carries out the user's requests in them.
    fn draw_panels(&mut self, event_loop: &ActiveEventLoop) {
        let over_panels = self.is_over_panels();
        let (magnified, region) = (self.magnified(), self.magnifier.region());
        let extent = self.session.viewport().window();
        let Some(Open { window, overlay, .. }) = &mut self.window else { return };
        let shown = panel_data::shown(self.session.debug_target(), self.session.graph());
        let locked = self.before_peek.as_ref().unwrap_or(self.session.debug_target());
        let locked = panel_data::shown(locked, self.session.graph());
        let status = Status {
            graph: self.session.graph().name.clone(),
            is_default: shown
                == panel_data::shown(&raxel_runtime::debug_target::DebugTarget::default(), self.session.graph()),
            shown,
            locked,
            paused: self.session.clock().paused(),
            recording: self.session.recording().map(|(seconds, _)| whole(seconds)),
            generation: self.reloads.shown,
            failed: self.reloads.failed,
            refused: self.session.is_refused(),
            busy: self.busy.clone(),
            compiling: self.session.compiling().map(|compiling| Compiling {
                pass: compiling.pass,
                seconds: compiling.elapsed.as_secs(),
                left: compiling.left,
            }),
            picture: if self.presented == 0 { FirstPicture::Awaited } else { FirstPicture::Shown },
            graph_file: self.session.graph_path().to_owned(),
            written: self.history.last_files(),
            notice: self.notice.as_ref().filter(|(_, until)| Instant::now() < *until).map(|(text, _)| text.clone()),
        };
        let cursor = self.controls.cursor().filter(|_| !over_panels);
        let cursor = cursor.map(|pixel| self.session.viewport().to_output(pixel));
        // Finding that voxel takes a walk through the world: only while a panel shows it.
        let says = self.panels.layout.is_open(Panel::World) && !over_panels;
        let pixel = self.controls.cursor().filter(|_| says).map(|pixel| self.magnifier.unmagnified(pixel, extent));
        let (hit, unavailable) = match pixel.map(|pixel| self.session.pick(pixel, brush::REACH)) {
            Some(Ok(hit)) => (hit, None),
            Some(Err(unavailable)) => (None, Some(unavailable.to_string())),
            None => (None, None),
        };
        let effect = brush::effect(&self.brush, self.modifiers);
        let outline = match hit.as_ref().map(|hit| brush::stroke(&self.brush, effect, hit)) {
            Some(Stroke::Edit(edit)) => {
                outline::outline(&edit, self.session.camera(), self.session.viewport().window())
            }
            Some(Stroke::Pick(_)) | None => Vec::new(),
        };
        let outline = outline.into_iter().map(|segment| segment.map(|point| self.magnifier.magnified(point, extent)));
        let outline = outline.collect();
        self.data.palette(self.session.scene());
        let steps = self.session.edit_steps();
        let editing = Editing {
            brush: self.brush,
            materials: self.data.swatches(),
            steps: [steps.undo, steps.redo],
            refused: self.refused.clone(),
            under: hit.as_ref().map(|hit| panel_data::under(&self.session, hit)).or(unavailable),
            outline,
        };
        let resources = self.data.resources();
        // Present counts and prints of passes stand beside the mistakes in the files.
        let counted = self.session.counted();
        let printed = self.session.printed();
        let with_counted = (!counted.is_empty() || !printed.is_empty())
            .then(|| [self.problems.clone(), problems(&counted, self.session.texts()), prints(printed)].concat());
        let params = self.data.params(&self.session);
        let view = View {
            status,
            frame: self.data.frame(&self.session, self.fps_cap),
            passes: self.data.passes(&self.session),
            resources,
            thumbnails: self.data.thumbnails(),
            presets: preset_list::view(&self.presets, self.session.graph_path(), &params),
            params,
            records: self.recorder.is_on(),
            checks_bounds: self.session.checks_bounds(),
            problems: with_counted.as_deref().unwrap_or(&self.problems),
            world: World { editing, ..panel_data::world(&self.session, self.controls.speed()) },
            timeline: panel_data::timeline(&self.session, self.looped),
            inspected: self.inspector.view(&self.session, resources, cursor, &region),
            magnified,
            compare: self.comparing.view(&self.session),
            files: self.files.get(),
        };
        let panels = &mut self.panels;
        let actions = overlay.draw(window, |context| panels.show(context, &view));
        for action in actions {
            self.perform(action, event_loop);
        }
        if !self.is_held() {
            self.history.let_go();
        }
        self.place_picture();
    }

    /// Puts the picture where the panels leave it. Its extent follows once no edge of a dock is held: targets are created again for it.
    fn place_picture(&mut self) {
        let Some(Open { presenter, overlay, .. }) = &mut self.window else { return };
        let Some(window) = presenter.extent() else { return };
        let place = overlay.picture(&self.panels).map(|[origin, extent]| Place { origin, extent, ground: GROUND });
        let held = overlay.is_held();
        if place != self.placed.place {
            presenter.set_place(place);
            self.controls.set_origin(place.map_or([0; 2], |place| place.origin));
            (self.placed, self.touched) = (Placed { place, outgrown: true }, true);
        }
        if self.placed.outgrown && !held {
            self.placed.outgrown = false;
            let [width, height] = place.map_or(window, |place| place.extent);
            self.session.resize(width, height);
        }
    }

    /// Shows the picture of the last frame with the panels over it. False when it could not be shown yet.
    pub(super) fn show(&mut self, event_loop: &ActiveEventLoop) -> Result<bool> {
        let pictures = self.window.as_ref().map(|open| open.pictures);
        if pictures == Some(Pictures::Other) {
            let progress = self.session.wait_picture(SLICE);
            if !self.is_done(progress)? {
                return Ok(false);
            }
        }
        let (Some(open), Some(picture)) = (&mut self.window, self.session.picture()) else { return Ok(true) };
        let visible = self.panels.are_drawn();
        // With a pass that is off, the picture is incomplete: the last whole one stays where it is kept.
        let whole = !self.session.outcomes().contains(&PassOutcome::Off);
        let presented = match open.pictures {
            Pictures::Same if open.presenter.device().id() != self.session.device().id() => {
                return self.reopen().map(|()| false);
            }
            Pictures::Same => open.overlay.present(&mut open.presenter, |presenter, overlay| {
                presenter.present(&picture, visible.then_some(overlay))
            }),
            Pictures::Other => {
                // Nothing else is on the device: the copy takes as long as one of the processor.
                match whole.then(|| self.session.read_presented()).transpose() {
                    Ok(Some(picture)) => open.presenter.take(&picture)?,
                    Ok(None) => {}
                    Err(ReadError::Execute(ExecuteError::DeviceLost { .. })) => {
                        // The next frame finds the loss, and reopens the device.
                        self.unshown = false;
                        return Ok(true);
                    }
                    // Those who wait for other copies free one soon.
                    Err(ReadError::Execute(ExecuteError::Gpu(raxel_gpu::Error::ReadbacksInFlight { .. }))) => {
                        return Ok(false);
                    }
                    Err(error) => return Err(error.into()),
                }
                open.present_taken(visible)
            }
        };
        match presented {
            Ok(Presented::Shown) => {
                self.refusals.end();
                self.presented += 1;
                if self.args.frames.is_some_and(|frames| self.presented >= frames) {
                    event_loop.exit();
                }
            }
            // A window without area is hidden, and shows nothing: here, the driver alone says so.
            Ok(Presented::NoArea | Presented::OutOfDate | Presented::NotReady) => {
                self.report_refusals();
                return Ok(false);
            }
            Err(error) if error.is_device_lost() && pictures == Some(Pictures::Other) => {
                self.report_refusals();
                return self.reopen().map(|()| false);
            }
            // The next frame finds the loss, and reopens the device.
            Err(error) if error.is_device_lost() => {}
            Err(error) => return Err(error.into()),
        }
        self.unshown = false;
        self.update_title();
        Ok(true)
    }

    /// The window refused a picture. Tells it, once, when that goes on for long.
    fn report_refusals(&mut self) {
        if self.refusals.add(Instant::now())
            && let Some(open) = &self.window
        {
            self.console.message(&refused(&open.presenter.device().capabilities().name));
        }
    }

    /// While the device works: draws the panels again over the last picture, where another device presents it.
    fn draw_meanwhile(&mut self, event_loop: &ActiveEventLoop) -> Result {
        let Some(open) = self.window.as_ref().filter(|open| open.pictures == Pictures::Other) else { return Ok(()) };
        let since = self.drawn.elapsed();
        let wanted = self.touched || open.overlay.is_due() || since >= REFRESH;
        if !wanted || since < MEANWHILE {
            return Ok(());
        }
        (self.touched, self.drawn) = (false, Instant::now());
        self.draw_panels(event_loop);
        let visible = self.panels.are_drawn();
        let Some(open) = &mut self.window else { return Ok(()) };
        match open.present_taken(visible) {
            Ok(_) => Ok(()),
            Err(error) if error.is_device_lost() => self.reopen(),
            Err(error) => Err(error.into()),
        }
    }

    /// Presents on another device from here on. The old surface belongs to the lost one; it goes before a new one is made for the same window.
    fn reopen(&mut self) -> Result {
        let Some(open) = self.window.take() else { return Ok(()) };
        let window = open.window.clone();
        drop(open);
        self.window = Some(self.opened(&window)?);
        self.placed = Placed::default();
        self.controls.set_origin([0; 2]);
        Ok(())
    }

    /// Whether the device has finished the awaited work. Names its work when that takes long, once until a frame is quick again.
    pub(super) fn is_done(&mut self, progress: std::result::Result<Progress, FrameError>) -> Result<bool> {
        match progress.map_err(|error| frame_failure(error, self.console))? {
            Progress::Done => {
                self.titled = self.titled.filter(|_| self.busy.is_none());
                self.busy = None;
                Ok(true)
            }
            Progress::Working { pass, elapsed } => {
                if elapsed >= if self.presented == 0 { PATIENCE_AT_FIRST } else { PATIENCE } {
                    // If every frame takes long, only the first one is reported.
                    let said = self.long.contains(&true);
                    self.long[0] = true;
                    if !said {
                        let on = pass.as_ref().map_or_else(String::new, |pass| format!(" on pass `{pass}`"));
                        let seconds = elapsed.as_secs();
                        self.console.message(&format!(
                            "the device has worked{on} for {seconds} s; Escape quits, Delete switches the pass off, and edits are still read"
                        ));
                    }
                    self.busy = Some(Busy { pass, seconds: elapsed.as_secs() });
                    self.update_title();
                    // Its pass has been mended: the picture is not needed.
                    if elapsed >= MENDED && self.session.works_on_replaced() {
                        self.busy = None;
                        self.session.cancel().map_err(|error| frame_failure(error, self.console))?;
                    }
                }
                Ok(false)
            }
        }
    }

    /// Moves the camera as keys and mouse ask. The first gesture takes over from a demo.
    fn fly(&mut self) {
        let now = Instant::now();
        let seconds = (now - self.last).as_secs_f64();
        self.last = now;
        let smoothed = self.frame_time.map_or(seconds, |old| old * 0.9 + seconds * 0.1);
        self.frame_time = Some(smoothed);
        self.data.interval.push(seconds * 1e3);
        let over_panels = self.is_over_panels();
        let cursor = self.controls.cursor().filter(|_| !over_panels);
        let window = self.session.viewport().window();
        self.session.set_cursor(cursor.map(|pixel| self.magnifier.unmagnified(pixel, window)));
        self.note_time_of_day();
        self.read_gamepad();
        self.read_microphone();
        self.end_take();
        let (mut input, speed) = self.controls.fly();
        // A drag moves a magnified picture; otherwise, it turns the camera.
        if self.magnifier.is_on() {
            let [width, height] = self.session.viewport().window().map(f64::from);
            let [x, y] = std::mem::take(&mut input.look);
            self.magnifier.pan([x / width, y / height]);
        }
        if input == FlyInput::default() {
            if self.history.flies() && !self.controls.is_flying() && self.flown.elapsed() > LANDED {
                self.land();
            }
            return;
        }
        self.history.fly(self.pose());
        self.flown = now;
        self.session.take_over();
        let mut camera = *self.session.camera();
        camera.fly(&input, &speed, seconds.min(0.25));
        self.session.set_camera(camera);
    }
}
