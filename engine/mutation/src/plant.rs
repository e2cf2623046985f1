//! Faults in Rust: where they fit in a source, and the source that holds all of them behind a switch.
//!
//! Each fault is an expression that asks whether its number is the one that runs, so that one build serves every fault. An expression is
//! rewritten from the inside out, and no operand is written twice. So the text only grows in proportion to the faults.

use std::collections::BTreeSet;
use std::ops::Range;

use proc_macro2::Span;
use syn::spanned::Spanned as _;
use syn::visit::Visit;
use syn::{BinOp, Expr, ExprLit, Lit, Stmt};

/// One fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the line of the source, from 1.
    pub line: usize,
    /// Text of that line.
    pub text: String,
    /// The text that it replaces: an operator, a number, a statement, the condition of an `if`.
    pub from: String,
    /// The text in its place.
    pub to: String,
    /// The bytes of the source that it lies in.
    pub range: Range<usize>,
}

/// How a fault is written: text to insert before some bytes and in place of others.
struct Edit {
    range: Range<usize>,
    text: String,
    /// Outer edits of the same place come first.
    depth: usize,
}

/// All faults of a source.
pub struct Planted {
    source: String,
    faults: Vec<(Fault, Vec<Edit>)>,
}

impl Planted {
    /// Finds the faults of a source.
    ///
    /// # Errors
    ///
    /// Fails if the source is not Rust.
    pub fn of(source: &str) -> syn::Result<Self> {
        let file = syn::parse_file(source)?;
        let mut finder = Finder { source, faults: Vec::new(), depth: 0 };
        finder.visit_file(&file);
        Ok(Self { source: source.to_owned(), faults: finder.faults })
    }

    /// The faults, in the order of the source.
    pub fn faults(&self) -> impl Iterator<Item = &Fault> {
        self.faults.iter().map(|(fault, _)| fault)
    }

    /// The source with all faults but those that are left out. Fault `i` is switched on by `crate::planted::is(first + i)`.
    pub fn text(&self, first: usize, left_out: &BTreeSet<usize>) -> (String, Vec<Range<usize>>) {
        let mut inserts: Vec<(usize, bool, usize, String)> = Vec::new();
        let mut removed: Vec<(Range<usize>, String)> = Vec::new();
        for (number, (_, edits)) in self.faults.iter().enumerate().filter(|(number, _)| !left_out.contains(number)) {
            for edit in edits {
                let text = edit.text.replace("{is}", &format!("crate::planted::is({})", first + number));
                if edit.range.is_empty() {
                    // Closing texts come before opening ones, closings from the inside out, openings from the outside in.
                    let opens = text.ends_with(['(', '{', ' ']);
                    inserts.push((
                        edit.range.start,
                        opens,
                        if opens { edit.depth } else { usize::MAX - edit.depth },
                        text,
                    ));
                } else {
                    removed.push((edit.range.clone(), text));
                }
            }
        }
        inserts.extend(removed.iter().map(|(range, text)| (range.start, true, usize::MAX, text.clone())));
        inserts.sort();
        removed.sort_by_key(|(range, _)| range.start);
        let (mut out, mut at, mut lines) = (String::new(), 0, Vec::new());
        for (place, _, _, text) in inserts {
            if place > at {
                push(&mut out, &mut lines, &self.source, at..place);
                at = place;
            }
            out.push_str(&text);
            if let Some((range, _)) = removed.iter().find(|(range, of)| range.start == place && *of == text) {
                at = range.end;
            }
        }
        push(&mut out, &mut lines, &self.source, at..self.source.len());
        (out, lines)
    }
}

/// Copies a part of the source and notes where it went: bytes of the text, then bytes of the source, in turns.
fn push(out: &mut String, parts: &mut Vec<Range<usize>>, source: &str, part: Range<usize>) {
    parts.push(out.len()..out.len() + part.len());
    parts.push(part.clone());
    out.push_str(&source[part]);
}

/// The byte of the source that a byte of the text came from, or the next one that did.
pub fn origin(parts: &[Range<usize>], byte: usize) -> usize {
    let at = parts.chunks(2).find(|pair| byte < pair[0].end);
    at.map_or(usize::MAX, |pair| pair[1].start + byte.saturating_sub(pair[0].start))
}

struct Finder<'a> {
    source: &'a str,
    faults: Vec<(Fault, Vec<Edit>)>,
    depth: usize,
}

fn bytes(span: Span) -> Range<usize> {
    span.byte_range()
}

impl Finder<'_> {
    fn add(&mut self, at: Range<usize>, [from, to]: [&str; 2], of: Range<usize>, edits: Vec<(Range<usize>, String)>) {
        let before = &self.source[..at.start];
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let fault = Fault {
            line: before.matches('\n').count() + 1,
            text: self.source[start..].lines().next().unwrap_or_default().trim().to_owned(),
            from: from.to_owned(),
            to: to.to_owned(),
            range: of,
        };
        let depth = self.depth;
        let edits = edits.into_iter().map(|(range, text)| Edit { range, text, depth }).collect();
        self.faults.push((fault, edits));
    }

    /// `left op right` with other operators in the place of `op`.
    fn operator(&mut self, whole: Range<usize>, left: Range<usize>, op: Range<usize>, right: Range<usize>, to: &str) {
        let from = self.source[op.clone()].to_owned();
        let gap = left.end..right.start;
        let (start, end) = (whole.start..whole.start, whole.end..whole.end);
        // A comment in the gap stays out of the way.
        let edits = match from.as_str() {
            "&&" => {
                vec![(start, "{ let l = ".into()), (gap, "; if l != {is} { ".into()), (end, " } else { l } }".into())]
            }
            "||" => {
                vec![(start, "{ let l = ".into()), (gap, "; if l == {is} { ".into()), (end, " } else { l } }".into())]
            }
            "<" | "<=" | ">" | ">=" | "==" | "!=" => vec![
                (start, "(match (&(".into()),
                (gap, "), &(".into()),
                (end, format!(")) {{ (l, r) => if {{is}} {{ *l {to} *r }} else {{ *l {from} *r }} }})")),
            ],
            _ => vec![
                (start, "(match (".into()),
                (gap, ", ".into()),
                (end, format!(") {{ (l, r) => if {{is}} {{ l {to} r }} else {{ l {from} r }} }})")),
            ],
        };
        self.add(op, [&from, to], whole, edits);
    }
}

fn holds_let(expr: &Expr) -> bool {
    match expr {
        Expr::Let(_) => true,
        Expr::Binary(binary) => holds_let(&binary.left) || holds_let(&binary.right),
        Expr::Paren(paren) => holds_let(&paren.expr),
        _ => false,
    }
}

fn other(op: &BinOp) -> Option<&'static str> {
    Some(match op {
        BinOp::Add(_) => "-",
        BinOp::Sub(_) => "+",
        BinOp::Mul(_) | BinOp::Rem(_) => "/",
        BinOp::Div(_) => "*",
        BinOp::And(_) => "||",
        BinOp::Or(_) => "&&",
        BinOp::BitAnd(_) | BinOp::BitXor(_) => "|",
        BinOp::BitOr(_) => "&",
        BinOp::Shl(_) => ">>",
        BinOp::Shr(_) => "<<",
        BinOp::Eq(_) => "!=",
        BinOp::Ne(_) => "==",
        BinOp::Lt(_) => "<=",
        BinOp::Le(_) => "<",
        BinOp::Gt(_) => ">=",
        BinOp::Ge(_) => ">",
        _ => return None,
    })
}

/// Whether attributes say that something is for tests alone.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::Path(path) => path.is_ident("test"),
        syn::Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string().contains("test"),
        syn::Meta::NameValue(_) => false,
    })
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            syn::visit::visit_item_mod(self, item);
        }
    }

    // A constant is worked out by the compiler, which has no switch.
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_path(&mut self, _: &'ast syn::Path) {}
    fn visit_macro(&mut self, _: &'ast syn::Macro) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if item.sig.constness.is_none() && !is_test(&item.attrs) {
            syn::visit::visit_item_fn(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if item.sig.constness.is_none() {
            syn::visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_stmt(&mut self, stmt: &'ast Stmt) {
        self.depth += 1;
        if let Stmt::Expr(expr, Some(_)) = stmt {
            let may_go = matches!(
                expr,
                Expr::MethodCall(_)
                    | Expr::Call(_)
                    | Expr::Assign(_)
                    | Expr::Binary(_)
                    | Expr::Continue(_)
                    | Expr::Break(_)
                    | Expr::Return(_)
            );
            if may_go {
                let whole = bytes(stmt.span());
                let text = self.source[whole.clone()].to_owned();
                let edits =
                    vec![(whole.start..whole.start, "if !{is} { ".to_owned()), (whole.end..whole.end, " }".to_owned())];
                self.add(whole.clone(), [&text, ""], whole, edits);
            }
        }
        syn::visit::visit_stmt(self, stmt);
        self.depth -= 1;
    }

    fn visit_expr(&mut self, expr: &'ast Expr) {
        self.depth += 1;
        match expr {
            Expr::Binary(binary) if !holds_let(expr) => {
                if let Some(to) = other(&binary.op) {
                    let [whole, left, right] = [expr.span(), binary.left.span(), binary.right.span()].map(bytes);
                    self.operator(whole, left, bytes(binary.op.span()), right, to);
                }
            }
            Expr::If(branch) if !holds_let(&branch.cond) => {
                let cond = bytes(branch.cond.span());
                let text = self.source[cond.clone()].to_owned();
                let edits =
                    vec![(cond.start..cond.start, "({is} != (".to_owned()), (cond.end..cond.end, "))".to_owned())];
                self.add(cond.clone(), [&text, "its negation"], cond, edits);
            }
            Expr::Lit(ExprLit { lit: Lit::Int(lit), .. }) => {
                let at = bytes(lit.span());
                let (from, value) = (self.source[at.clone()].to_owned(), lit.base10_parse::<u64>());
                if let Ok(value) = value
                    && value < u64::MAX
                {
                    let to = format!("{}{}", value + 1, lit.suffix());
                    let text = format!("(if {{is}} {{ {to} }} else {{ {from} }})");
                    self.add(at.clone(), [&from, &to], at.clone(), vec![(at, text)]);
                }
            }
            Expr::MethodCall(call) if call.turbofish.is_none() => {
                let name = call.method.to_string();
                let whole = bytes(expr.span());
                match (name.as_str(), call.args.first()) {
                    ("min" | "max" | "saturating_sub", Some(argument)) if call.args.len() == 1 => {
                        let to = match name.as_str() {
                            "min" => "max",
                            "max" => "min",
                            _ => "saturating_add",
                        };
                        let [receiver, argument] = [call.receiver.span(), argument.span()].map(bytes);
                        let edits = vec![
                            (whole.start..whole.start, "(match (".to_owned()),
                            (receiver.end..argument.start, ", ".to_owned()),
                            (
                                argument.end..whole.end,
                                format!(") {{ (l, r) => if {{is}} {{ l.{to}(r) }} else {{ l.{name}(r) }} }})"),
                            ),
                        ];
                        self.add(bytes(call.method.span()), [&name, to], whole, edits);
                    }
                    ("any" | "all" | "contains" | "contains_key" | "is_empty", _) => {
                        let edits = vec![
                            (whole.start..whole.start, "({is} != ".to_owned()),
                            (whole.end..whole.end, ")".to_owned()),
                        ];
                        self.add(bytes(call.method.span()), [&name, "its negation"], whole, edits);
                    }
                    _ => {}
                }
            }
            _ => {}
        }
        syn::visit::visit_expr(self, expr);
        self.depth -= 1;
    }
}
