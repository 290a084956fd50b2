//! Whether a function can change an array that it captures.
//!
//! A captured array of a million handles is not worth comparing before each frame if no function
//! that holds it can change it. The answer leans to yes: only what is known to read counts.

use rhai::{AST, ASTFlags, ASTNode, BinaryExpr, Expr, FnCallExpr, FnPtr, Stmt};

/// Methods of arrays that only read.
const READING: &[&str] = &["len", "is_empty", "contains", "index_of"];
/// How many closures deep a capture is followed.
const DEPTH: usize = 16;

/// Whether `function`, which holds the variable as its `at`-th captured one, can change it, an
/// array of handles: handles themselves never change, whatever is written through them.
pub(crate) fn may_change(ast: &AST, function: &FnPtr, at: usize) -> bool {
    changes(ast, function, at, DEPTH)
}

fn changes(ast: &AST, function: &FnPtr, at: usize, depth: usize) -> bool {
    let own = function.fn_name();
    let mut definitions = ast.iter_fn_def().filter(|f| f.name == own && f.params.len() > at);
    let Some(definition) = definitions.next().filter(|_| depth > 0) else { return true };
    // Names of closures are unique; a `fn` may exist with several numbers of parameters.
    if definitions.next().is_some() {
        return true;
    }
    let name = &definition.params[at];
    let params = definition.params.len();
    let alone = ast.clone_functions_only_filtered(|_, _, _, f, n| f == own && n == params);
    let mut found = false;
    alone.walk(&mut |path: &[ASTNode]| {
        found |= match path.last() {
            Some(ASTNode::Stmt(Stmt::Assignment(x))) => assigns(&x.1.lhs, name),
            Some(ASTNode::Stmt(Stmt::FnCall(call, _)))
            | Some(ASTNode::Expr(Expr::FnCall(call, _))) => hands_on(ast, call, name, depth),
            Some(ASTNode::Expr(Expr::Dot(x, ..))) => is(&x.lhs, name) && calls(&x.rhs),
            Some(ASTNode::Expr(Expr::Index(x, ..))) => is(&x.lhs, name) && any_call(x),
            _ => false,
        };
        !found
    });
    found
}

fn is(expr: &Expr, name: &str) -> bool {
    matches!(expr, Expr::Variable(x, ..) if x.1 == name)
}

/// Whether the left side of an assignment is the array or one of its places.
fn assigns(left: &Expr, name: &str) -> bool {
    match left {
        // `balls[i] = ...` ends the chain at the place; `balls[i].radius = ...` goes on.
        Expr::Index(x, flags, _) => is(&x.lhs, name) && flags.contains(ASTFlags::BREAK),
        other => is(other, name),
    }
}

/// Whether the first step after the array is a method that may write.
fn calls(step: &Expr) -> bool {
    match step {
        Expr::MethodCall(call, _) => !READING.contains(&call.name.as_str()),
        Expr::Dot(x, ..) | Expr::Index(x, ..) => calls(&x.lhs),
        Expr::Property(..) => false,
        _ => true,
    }
}

/// Whether a method is called anywhere on the way from one of the array's places: a method of the
/// script's own may assign to `this`.
fn any_call(x: &BinaryExpr) -> bool {
    match &x.rhs {
        Expr::Dot(next, ..) | Expr::Index(next, ..) => {
            matches!(next.lhs, Expr::MethodCall(..)) || any_call(next)
        }
        Expr::MethodCall(..) => true,
        _ => false,
    }
}

/// Whether a closure made here captures the array and may change it. Any other function gets a
/// copy, because captured variables are shared.
fn hands_on(ast: &AST, call: &FnCallExpr, name: &str, depth: usize) -> bool {
    if call.name != "curry" {
        return false;
    }
    let Some(at) = call.args.iter().skip(1).position(|arg| is(arg, name)) else { return false };
    let inner = call.args[0].get_literal_value(None).and_then(|v| v.try_cast::<FnPtr>());
    inner.is_none_or(|inner| changes(ast, &inner, at, depth - 1))
}
