//! `niji view`: a page on this machine that shows the scene while it is worked on.

mod address;
mod desk;
mod document;
mod http;
mod page;
mod painter;
mod picture;
mod routes;
mod toml_values;

use std::net::Ipv4Addr;
use std::net::TcpListener;
use std::path::PathBuf;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering;
use std::thread;

use clap::Args;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::scene_file;
use crate::view::address::Address;
use crate::view::desk::Desk;
use crate::view::document::Document;
use crate::view::painter::Painter;
use crate::view::routes::Routes;

/// Most connections at a time: a browser opens six.
const MOST_CONNECTIONS: usize = 64;

/// Show a scene in the browser while you work on it.
///
/// Prints the address of a page on this machine, which nobody else can open, and serves it until Ctrl-C. The picture
/// follows every change: coarse at once, then finer, and as `niji run` makes it when the hand rests. The scene's file
/// changes only by "Save", which keeps its comments and order.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji view data/scenes/rain-cell.toml
  niji view scene.toml --port 8080
  niji view scene.toml --accuracy draft")]
pub(crate) struct ViewCommand {
    /// The scene.
    scene: PathBuf,
    /// The port to listen on [default: one that is free].
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
}

/// Serves the page for ever.
///
/// # Errors
/// A scene that is missing, wrong or not shown; a port that is taken.
pub(crate) fn execute(command: &ViewCommand, common: &Common) -> Result<(), Failure> {
    // As every command reads it; here its files are opened only to paint.
    scene_file::read(&command.scene, common)?;
    let document = Document::open(&command.scene, common.goal())?;
    let failed = |error: std::io::Error| {
        Failure::Failed(format!("cannot listen on port {}: {error}", command.port))
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, command.port)).map_err(failed)?;
    let port = listener.local_addr().map_err(failed)?.port();
    let address = Address::new(port);
    let address = address.map_err(|error| Failure::Failed(format!("no random number: {error}")))?;
    let desk = Desk::new(document);
    let routes = Routes {
        address: &address,
        desk: &desk,
        common,
    };
    output::print(&format!("{}\n", address.url()))?;
    common
        .verbosity()
        .say("serving this page on this machine alone; Ctrl-C ends it");
    let n_open = AtomicUsize::new(0);
    thread::scope(|scope| {
        scope.spawn(|| Painter::new(&desk, &command.scene).paint());
        for stream in listener.incoming() {
            // One that is gone before it was taken is no matter.
            let Ok(stream) = stream else { continue };
            let (open, routes) = (Open::new(&n_open), &routes);
            if n_open.load(Ordering::Acquire) <= MOST_CONNECTIONS {
                scope.spawn(move || {
                    http::serve(&stream, |request| routes.answer(request));
                    drop(open);
                });
            }
        }
    });
    Ok(())
}

/// A connection that is counted.
struct Open<'a>(&'a AtomicUsize);

impl<'a> Open<'a> {
    fn new(n_open: &'a AtomicUsize) -> Self {
        n_open.fetch_add(1, Ordering::AcqRel);
        Self(n_open)
    }
}

impl Drop for Open<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}
