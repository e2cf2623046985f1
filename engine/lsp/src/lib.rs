//! `raxel lsp`: a language server for graphs, worlds, demos and their shaders. docs/editors.md has the lines that each editor needs.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod actions;
mod builtins;
mod call_types;
mod complete;
mod documents;
mod expressions;
mod glsl;
mod glsl_types;
mod hints;
mod hover;
mod indexed_text;
mod library_files;
mod member_access;
mod names;
mod progress;
mod project_texts;
mod publish;
mod references;
mod scopes;
mod signature;
mod symbols;
mod toml_names;
mod toml_place;

use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, after, bounded, never, select};
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, DidSaveTextDocument, Notification as _,
};
use lsp_types::request::{
    CodeActionRequest, Completion, DocumentSymbolRequest, GotoDefinition, HoverRequest, InlayHintRequest, References,
    Rename, Request as _, SignatureHelpRequest,
};
use lsp_types::{
    CodeActionParams, CodeActionProviderCapability, CompletionOptions, CompletionParams, DidChangeTextDocumentParams,
    DidCloseTextDocumentParams, DidOpenTextDocumentParams, DocumentSymbolParams, GotoDefinitionParams,
    GotoDefinitionResponse, HoverParams, HoverProviderCapability, InlayHintParams, OneOf, ReferenceParams,
    RenameParams, ServerCapabilities, SignatureHelpOptions, SignatureHelpParams, TextDocumentSyncCapability,
    TextDocumentSyncKind, Url,
};
use serde::de::DeserializeOwned;
use serde_json::json;

use self::documents::Documents;
use self::progress::Progress;
use self::publish::{Checker, Found, Look, Said};
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Failure, Result};

/// Runs a language server for graphs, worlds, demos and shaders on stdin and stdout.
///
/// It has the diagnostics of `raxel check` as you type, completion, hover texts, definitions, references and rename. docs/editors.md says how to
/// set up an editor.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Accepted and ignored: some editors pass it, and stdin and stdout are the only way.
    #[arg(long)]
    stdio: bool,
}

/// Time after the last key before files are checked: as long as the last check took, within these bounds. Somebody who types pays for no check that
/// takes long, and waits for none that is quick.
const SETTLE: RangeInclusive<Duration> = Duration::from_millis(15)..=Duration::from_millis(120);

/// Answers an editor on stdin and stdout until it stops.
pub fn run(_: &Args, console: &Console) -> Result {
    let (connection, threads) = Connection::stdio();
    let ended =
        |error: &dyn std::fmt::Display| Failure::usage(format!("the conversation with the editor has ended: {error}"));
    serve(connection).map_err(|error| ended(&error))?;
    console.detail("the editor has said goodbye");
    threads.join().map_err(|error| ended(&error))
}

/// Answers an editor until it stops.
///
/// # Errors
/// The editor breaks the protocol, or goes away without a word.
pub fn serve(connection: Connection) -> std::result::Result<(), Ended> {
    let capabilities = ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(["\"", ".", "=", "[", "_", "<", "/"].map(str::to_owned).to_vec()),
            ..CompletionOptions::default()
        }),
        definition_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        signature_help_provider: Some(SignatureHelpOptions {
            trigger_characters: Some(["(", ","].map(str::to_owned).to_vec()),
            ..SignatureHelpOptions::default()
        }),
        references_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Left(true)),
        code_action_provider: Some(CodeActionProviderCapability::Simple(true)),
        inlay_hint_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    };
    let (id, params) = connection.initialize_start()?;
    let greeting = json!({
        "capabilities": capabilities,
        "serverInfo": { "name": "raxel", "version": env!("CARGO_PKG_VERSION") },
    });
    connection.initialize_finish(id, greeting)?;
    Server {
        connection,
        documents: Documents::default(),
        checking: Checking::Idle(Checker::default()),
        said: Said::default(),
        progress: Progress::of(&params),
        settle: *SETTLE.end(),
    }
    .serve()
}

/// A conversation with an editor.
struct Server {
    connection: Connection,
    documents: Documents,
    checking: Checking,
    said: Said,
    progress: Progress,
    /// Time after the last key before files are checked.
    settle: Duration,
}

/// Files are checked on a thread of its own, since a check may compile every shader of a project: requests are answered meanwhile.
enum Checking {
    Idle(Checker),
    /// The thread sends the checker back, with what it found.
    Busy {
        done: Receiver<(Checker, Answer)>,
        documents: Documents,
        began: Instant,
    },
}

/// The task of the thread.
#[derive(Clone, Copy)]
enum Question {
    /// The errors in shaders that were edited.
    FirstLook,
    Check,
}

/// The result of the thread.
enum Answer {
    FirstLook(Look),
    Check(Found),
}

/// Why a conversation ended early.
pub type Ended = Box<dyn std::error::Error + Send + Sync>;

impl Server {
    fn serve(mut self) -> std::result::Result<(), Ended> {
        // When the files that were changed are checked, and looked at before that.
        let (mut due, mut first_look): (Option<Instant>, Option<Instant>) = (None, None);
        loop {
            let left = |due: Option<Instant>| due.map(|due| due.saturating_duration_since(Instant::now()));
            let (checked, timer) = match &self.checking {
                Checking::Idle(_) => (never(), left(first_look.or(due))),
                Checking::Busy { done, began, .. } => (done.clone(), left(self.progress.due(*began))),
            };
            let timer = timer.map_or_else(never, after);
            select! {
                recv(self.connection.receiver) -> message => match message {
                    Ok(Message::Request(request)) => {
                        if self.connection.handle_shutdown(&request)? {
                            return Ok(());
                        }
                        let answer = self.answer(request);
                        self.connection.sender.send(Message::Response(answer))?;
                    }
                    Ok(Message::Notification(notification)) => {
                        if self.take(notification) {
                            let now = Instant::now();
                            due = Some(now + self.settle);
                            first_look = Some(now + *SETTLE.start()).filter(|first_look| Some(*first_look) < due);
                        }
                    }
                    Ok(Message::Response(_)) => {}
                    Err(_) => return Ok(()),
                },
                recv(checked) -> checked => {
                    let (checker, answer) = checked.map_err(|_| "the thread that checks files has ended")?;
                    // After a slow look too, the next key comes before the check: a check would hold up its look.
                    if let Answer::FirstLook(_) = answer {
                        due = due.map(|due| due.max(Instant::now() + *SETTLE.start()));
                    }
                    self.tell(checker, answer)?;
                }
                recv(timer) -> _ => match &self.checking {
                    Checking::Idle(_) if first_look.take().is_some() => self.begin(Question::FirstLook)?,
                    Checking::Idle(_) => {
                        due = None;
                        self.begin(Question::Check)?;
                    }
                    Checking::Busy { .. } => self.progress.begin(&self.connection.sender)?,
                },
            }
        }
    }

    /// Begins a check of the texts as they are now, or a first look at them.
    fn begin(&mut self, question: Question) -> std::result::Result<(), Ended> {
        let (sender, receiver) = bounded(1);
        let documents = self.documents.clone();
        let busy = Checking::Busy { done: receiver, documents: documents.clone(), began: Instant::now() };
        let before = std::mem::replace(&mut self.checking, busy);
        let Checking::Idle(mut checker) = before else {
            self.checking = before;
            return Ok(());
        };
        std::thread::Builder::new().name("check".to_owned()).spawn(move || {
            let answer = match question {
                Question::FirstLook => Answer::FirstLook(checker.first_look(&documents)),
                Question::Check => Answer::Check(checker.check(&documents)),
            };
            // Without a server, nobody is told.
            let _ = sender.send((checker, answer));
        })?;
        Ok(())
    }

    /// Tells what was found.
    fn tell(&mut self, checker: Checker, answer: Answer) -> std::result::Result<(), Ended> {
        let before = std::mem::replace(&mut self.checking, Checking::Idle(checker));
        self.progress.end(&self.connection.sender)?;
        let Checking::Busy { documents, began, .. } = before else { return Ok(()) };
        let messages = match answer {
            Answer::FirstLook(look) => self.said.first_messages(look, &documents, &self.documents),
            Answer::Check(found) => {
                self.settle = began.elapsed().clamp(*SETTLE.start(), *SETTLE.end());
                self.said.messages(found, &documents, &self.documents)
            }
        };
        for message in messages {
            self.connection.sender.send(Message::Notification(message))?;
        }
        Ok(())
    }

    /// Takes a change. True when files are to be checked.
    fn take(&mut self, notification: Notification) -> bool {
        match notification.method.as_str() {
            DidOpenTextDocument::METHOD => {
                if let Some(opened) = parsed::<DidOpenTextDocumentParams>(notification.params) {
                    self.documents.set(&opened.text_document.uri, opened.text_document.text);
                }
            }
            DidChangeTextDocument::METHOD => {
                if let Some(changed) = parsed::<DidChangeTextDocumentParams>(notification.params)
                    && let Some(whole) = changed.content_changes.into_iter().next_back()
                {
                    self.documents.set(&changed.text_document.uri, whole.text);
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Some(closed) = parsed::<DidCloseTextDocumentParams>(notification.params) {
                    self.documents.remove(&closed.text_document.uri);
                }
            }
            DidSaveTextDocument::METHOD => {}
            _ => return false,
        }
        true
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        match method.as_str() {
            Completion::METHOD => self.reply(id, params, |server, params: CompletionParams| {
                let at = params.text_document_position;
                let (document, offset) = server.documents.at(&at.text_document.uri, at.position)?;
                Some(json!(complete::items(&server.documents, document, offset)))
            }),
            HoverRequest::METHOD => self.reply(id, params, |server, params: HoverParams| {
                let at = params.text_document_position_params;
                let (document, offset) = server.documents.at(&at.text_document.uri, at.position)?;
                let text = hover::hover(&server.documents, document, offset)?;
                Some(json!({ "contents": { "kind": "markdown", "value": text } }))
            }),
            GotoDefinition::METHOD => self.reply(id, params, |server, params: GotoDefinitionParams| {
                let at = params.text_document_position_params;
                let (document, offset) = server.documents.at(&at.text_document.uri, at.position)?;
                let location = names::definition(&server.documents, document, offset)?;
                Some(json!(GotoDefinitionResponse::Scalar(location)))
            }),
            DocumentSymbolRequest::METHOD => self.reply(id, params, |server, params: DocumentSymbolParams| {
                let document = server.documents.get(&params.text_document.uri)?;
                Some(json!(symbols::symbols(document)))
            }),
            SignatureHelpRequest::METHOD => self.reply(id, params, |server, params: SignatureHelpParams| {
                let at = params.text_document_position_params;
                let (document, offset) = server.documents.at(&at.text_document.uri, at.position)?;
                Some(json!(signature::help(&server.documents, document, offset)?))
            }),
            References::METHOD => self.reply(id, params, |server, params: ReferenceParams| {
                let at = params.text_document_position;
                let (document, offset) = server.documents.at(&at.text_document.uri, at.position)?;
                let uses = references::uses(&server.documents, document, offset).ok()?;
                Some(json!(references::locations(document, &uses)))
            }),
            Rename::METHOD => match serde_json::from_value::<RenameParams>(params) {
                Ok(params) => match self.rename(&params) {
                    Ok(edit) => Response::new_ok(id, edit),
                    Err(reason) => Response::new_err(id, ErrorCode::RequestFailed as i32, reason),
                },
                Err(error) => Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string()),
            },
            CodeActionRequest::METHOD => self.reply(id, params, |server, params: CodeActionParams| {
                let document = server.documents.get(&params.text_document.uri)?;
                Some(json!(actions::actions(&server.documents, document, &params)))
            }),
            InlayHintRequest::METHOD => self.reply(id, params, |server, params: InlayHintParams| {
                let document = server.documents.get(&params.text_document.uri).filter(|document| document.is_toml())?;
                let at = |position| documents::offset(&document.text, position);
                let part = at(params.range.start)..at(params.range.end);
                Some(json!(hints::hints(&server.documents, document, &part)))
            }),
            _ => Response::new_err(id, ErrorCode::MethodNotFound as i32, format!("`{method}` is not offered")),
        }
    }

    /// The edits of a rename, or why it is refused.
    fn rename(&self, params: &RenameParams) -> std::result::Result<lsp_types::WorkspaceEdit, String> {
        let at = &params.text_document_position;
        let opened = self.documents.at(&at.text_document.uri, at.position);
        let (document, offset) = opened.ok_or("the file is in no project of raxel")?;
        let uses = references::uses(&self.documents, document, offset)?;
        references::rename(document, &uses, &params.new_name)
    }

    /// Reads the parameters, and gives null where there is nothing to say.
    fn reply<P: DeserializeOwned>(
        &self,
        id: RequestId,
        params: serde_json::Value,
        answer: impl FnOnce(&Self, P) -> Option<serde_json::Value>,
    ) -> Response {
        match serde_json::from_value(params) {
            Ok(params) => Response::new_ok(id, answer(self, params).unwrap_or_default()),
            Err(error) => Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string()),
        }
    }
}

fn parsed<P: DeserializeOwned>(params: serde_json::Value) -> Option<P> {
    serde_json::from_value(params).ok()
}

/// The address of a file.
fn address(path: &std::path::Path) -> Option<Url> {
    Url::from_file_path(path).ok()
}
