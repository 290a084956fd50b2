//! Closures that capture a `for` variable and outlive their turn of the loop.
//!
//! Rhai writes the next value into the variable that a closure has captured, so all closures of a
//! loop see its last one. One that is used up within its turn is right. This is an escape analysis
//! over the text: where the value of each closure goes, followed through variables and parameters
//! of the script's functions. Where it is not known, the closure outlives its turn.

use crate::locate::before;
use rhai::{AST, ASTNode, Expr, FnCallExpr, Position, Stmt, StmtBlock};
use std::collections::HashMap;

/// Functions and methods that call a function and do not keep it.
const CALLERS: &[&str] = &[
    "all",
    "call",
    "dedup",
    "drain",
    "extract",
    "fill_with",
    "filter",
    "find",
    "find_map",
    "for_each",
    "index_of",
    "keys",
    "map",
    "order_by",
    "reduce",
    "reduce_rev",
    "retain",
    "some",
    "sort",
    "sort_by",
    "zip",
];
/// Functions and methods that only look at what they are given or called on.
const LOOKERS: &[&str] =
    &["all", "call", "debug", "for_each", "is_empty", "len", "print", "some", "type_of"];
/// How many variables and parameters a value is followed through.
const STEPS: usize = 16;

/// Where a value goes.
#[derive(Clone, Debug)]
enum Flow {
    /// Nowhere: it is called, looked at or dropped.
    Used,
    /// Somewhere that may outlive the turn of the loop.
    Escapes,
    /// Into a variable of this name, known between two places.
    Variable(String, Position, Position),
    /// Into the function of this name and number of parameters, as which of them.
    Argument(String, usize, usize),
}

/// A mention of a variable, or its capture by a closure: where, and where the value goes.
type Mention = (Position, Flow);

/// All that the analysis needs, from one walk over the script.
#[derive(Default)]
struct Found {
    mentions: HashMap<String, Vec<Mention>>,
    /// Captures: the variable, its place, whose variable it is, and where the closure goes.
    captures: Vec<(String, Position, Owner, Flow)>,
    /// The bodies of the loops over a variable of this name.
    loops: HashMap<String, Vec<(Position, Position)>>,
}

/// Whose variable a name means.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    Loop,
    Let,
    /// None in the same function.
    Outer,
}

/// The first capture of a `for` variable by a closure that outlives its turn: its name and place.
pub(crate) fn loop_variable(ast: &AST) -> Option<(String, Position)> {
    let mut found = Found::default();
    ast.walk(&mut |path: &[ASTNode]| {
        found.visit(path);
        true
    });
    let captured = |(name, at, owner, flow): &(String, Position, Owner, Flow)| {
        let of_loop = match owner {
            Owner::Loop => true,
            Owner::Let => false,
            // A closure within a closure captures what that one captured.
            Owner::Outer => found
                .loops
                .get(name)
                .is_some_and(|bodies| bodies.iter().any(|(from, to)| within(*at, *from, *to))),
        };
        of_loop && !found.used_up(ast, flow, STEPS)
    };
    let first = found.captures.iter().filter(|c| captured(c)).map(|c| (c.0.clone(), c.1));
    first.reduce(|a, b| if before(b.1, Some(a.1)) { b } else { a })
}

fn within(at: Position, from: Position, to: Position) -> bool {
    !before(at, Some(from)) && (to.is_none() || !before(to, Some(at)))
}

impl Found {
    fn visit(&mut self, path: &[ASTNode]) {
        match path.last() {
            Some(ASTNode::Stmt(Stmt::Share(shared))) => {
                let flow = flow(path, path.len().saturating_sub(2));
                for (variable, _) in shared.iter() {
                    let (name, at) = (variable.name.to_string(), variable.pos);
                    self.mentions.entry(name.clone()).or_default().push((at, flow.clone()));
                    self.captures.push((name.clone(), at, owner(path, &name), flow.clone()));
                }
            }
            Some(ASTNode::Stmt(Stmt::For(x, _))) => {
                let body = (x.2.body.position(), x.2.body.end_position());
                let names = std::iter::once(&x.0).chain(x.1.as_ref());
                names.for_each(|n| self.loops.entry(n.name.to_string()).or_default().push(body));
            }
            Some(ASTNode::Expr(Expr::Variable(x, _, at))) => {
                let flow = flow(path, path.len() - 1);
                self.mentions.entry(x.1.to_string()).or_default().push((*at, flow));
            }
            _ => {}
        }
    }

    /// Whether a value that goes there is used up.
    fn used_up(&self, ast: &AST, flow: &Flow, steps: usize) -> bool {
        let Some(left) = steps.checked_sub(1) else { return false };
        let all = |name: &str, from: Position, to: Position| {
            let mentions = self.mentions.get(name).map_or(&[][..], Vec::as_slice);
            let mut there = mentions.iter().filter(|(at, _)| within(*at, from, to));
            there.all(|(_, flow)| self.used_up(ast, flow, left))
        };
        match flow {
            Flow::Used => true,
            Flow::Escapes => false,
            Flow::Variable(name, from, to) => all(name, *from, *to),
            Flow::Argument(name, count, index) => {
                let own = |f: &&std::sync::Arc<rhai::ScriptFuncDef>| {
                    f.name == name && f.params.len() == *count
                };
                match ast.iter_fn_def().find(own) {
                    Some(f) => {
                        all(&f.params[*index], f.body.start_position(), f.body.end_position())
                    }
                    None => CALLERS.contains(&name.as_str()) || LOOKERS.contains(&name.as_str()),
                }
            }
        }
    }
}

/// Where the value of the node at a place in a path goes.
fn flow(path: &[ASTNode], value: usize) -> Flow {
    let mut at = value;
    while let Some(parent) = at.checked_sub(1) {
        let last = |block: &StmtBlock| match (&path[at], block.statements().last()) {
            (ASTNode::Stmt(stmt), Some(last)) => std::ptr::eq(*stmt, last),
            _ => false,
        };
        let is = |expr: &Expr| matches!(path[at], ASTNode::Expr(e) if std::ptr::eq(e, expr));
        match &path[parent] {
            ASTNode::Stmt(Stmt::Expr(_) | Stmt::Switch(..)) => {}
            ASTNode::Expr(Expr::Stmt(block)) if last(block) => {}
            ASTNode::Stmt(Stmt::Block(block)) if last(block) => {}
            ASTNode::Stmt(Stmt::If(x, _) | Stmt::TryCatch(x, _))
                if last(&x.body) || last(&x.branch) => {}
            ASTNode::Expr(Expr::Stmt(_))
            | ASTNode::Stmt(
                Stmt::Block(_)
                | Stmt::If(..)
                | Stmt::TryCatch(..)
                | Stmt::For(..)
                | Stmt::While(..)
                | Stmt::Do(..),
            )
            | ASTNode::Expr(Expr::InterpolatedString(..)) => return Flow::Used,
            ASTNode::Stmt(Stmt::Var(x, _, place)) => {
                return Flow::Variable(x.0.name.to_string(), *place, block_end(&path[..parent]));
            }
            ASTNode::Stmt(Stmt::Assignment(x)) if is(&x.1.lhs) => return Flow::Used,
            ASTNode::Stmt(Stmt::FnCall(call, _)) | ASTNode::Expr(Expr::FnCall(call, _)) => {
                // What `curry` is given is captured: that is a mention of its own.
                if call.op_token.is_some() || call.name == "curry" {
                    return Flow::Used;
                }
                return argument(call, &path[at]);
            }
            ASTNode::Expr(Expr::MethodCall(call, _)) => return argument(call, &path[at]),
            ASTNode::Expr(Expr::Dot(x, ..)) if is(&x.lhs) => {
                let step = match &x.rhs {
                    Expr::Dot(next, ..) | Expr::Index(next, ..) => &next.lhs,
                    step => step,
                };
                if matches!(step, Expr::MethodCall(m, _) if LOOKERS.contains(&m.name.as_str())) {
                    return Flow::Used;
                }
            }
            ASTNode::Expr(Expr::Index(x, ..)) if is(&x.rhs) => return Flow::Used,
            ASTNode::Expr(
                Expr::Index(..)
                | Expr::Array(..)
                | Expr::Map(..)
                | Expr::And(..)
                | Expr::Or(..)
                | Expr::Coalesce(..),
            ) => {}
            _ => return Flow::Escapes,
        }
        at = parent;
    }
    // The value of a function's last statement is what it returns.
    Flow::Escapes
}

fn argument(call: &FnCallExpr, given: &ASTNode) -> Flow {
    let is = |arg: &Expr| matches!(given, ASTNode::Expr(e) if std::ptr::eq(*e, arg));
    match call.args.iter().position(is) {
        Some(index) => Flow::Argument(call.name.to_string(), call.args.len(), index),
        None => Flow::Escapes,
    }
}

/// Where the innermost block at the end of a path ends; nowhere known in a function.
fn block_end(path: &[ASTNode]) -> Position {
    let block = path.iter().rev().find_map(|node| match node {
        ASTNode::Stmt(Stmt::For(x, _)) => Some(x.2.body.end_position()),
        ASTNode::Stmt(Stmt::Block(block)) => Some(block.end_position()),
        ASTNode::Expr(Expr::Stmt(block)) => Some(block.end_position()),
        ASTNode::Stmt(Stmt::If(x, _) | Stmt::TryCatch(x, _)) => {
            let (body, branch) = (x.body.end_position(), x.branch.end_position());
            Some(if branch.is_none() { body } else { branch })
        }
        ASTNode::Stmt(Stmt::While(x, _) | Stmt::Do(x, _, _)) => Some(x.body.end_position()),
        _ => None,
    });
    block.unwrap_or(Position::NONE)
}

/// Whose variable a name means at the end of a path: from the inside out, whichever of a `let`
/// before it and a loop's head comes first.
fn owner(path: &[ASTNode], name: &str) -> Owner {
    let mut child: Option<Position> = None;
    let defines = |block: &[Stmt], child: Option<Position>| {
        block.iter().any(|s| match s {
            Stmt::Var(x, _, at) => x.0.name == name && before(*at, child),
            _ => false,
        })
    };
    for node in path.iter().rev() {
        if let ASTNode::Stmt(stmt) = node {
            let bodies: Vec<&[Stmt]> = match stmt {
                Stmt::For(x, _) => vec![x.2.body.statements()],
                Stmt::Block(block) => vec![block.statements()],
                Stmt::If(x, _) | Stmt::While(x, _) | Stmt::Do(x, _, _) | Stmt::TryCatch(x, _) => {
                    vec![x.body.statements(), x.branch.statements()]
                }
                _ => Vec::new(),
            };
            if bodies.into_iter().any(|body| defines(body, child)) {
                return Owner::Let;
            }
            if let Stmt::For(x, _) = stmt
                && (x.0.name == name || x.1.as_ref().is_some_and(|second| second.name == name))
                // The loop's own range is outside of it.
                && child.is_some_and(|at| x.2.body.statements().iter().any(|s| s.position() == at))
            {
                return Owner::Loop;
            }
            child = Some(stmt.position());
        } else if let ASTNode::Expr(Expr::Stmt(block)) = node
            && defines(block.statements(), child)
        {
            return Owner::Let;
        }
    }
    Owner::Outer
}
