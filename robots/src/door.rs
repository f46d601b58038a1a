//! Where messages go: to viewers over a WebSocket, and into a file.

use std::fs::File;
use std::io::{self, BufWriter};
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use foxglove::{
    Context, FoxgloveError, McapCompression, McapWriteOptions, McapWriterHandle,
    WebSocketServerHandle,
};

use crate::Topics;

/// Why messages go nowhere.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum Error {
    #[error("no viewer can be let in at {at}: {source}")]
    Serve { at: SocketAddr, source: FoxgloveError },
    #[error("the MCAP file cannot be written: {0}")]
    Write(FoxgloveError),
    #[error("the MCAP file cannot be written: {0}")]
    Disk(#[from] io::Error),
    #[error("a topic cannot be opened: {0}")]
    Topic(FoxgloveError),
}

/// Topics of fingers, with those who listen. Viewers are let go and the file is ended with this value.
pub struct Door {
    context: Arc<Context>,
    server: Option<WebSocketServerHandle>,
    file: Option<McapWriterHandle<BufWriter<File>>>,
}

impl Door {
    /// One through which nobody listens yet.
    #[must_use]
    pub fn new() -> Self {
        Self { context: Context::new(), server: None, file: None }
    }

    /// The topics of the finger with this number, from 1.
    ///
    /// # Errors
    /// [`Error::Topic`].
    pub fn finger(&self, number: usize) -> Result<Topics, Error> {
        Topics::new(&self.context, number).map_err(Error::Topic)
    }

    /// Lets viewers in that speak the Foxglove protocol; port 0 stands for any that is free. They are shown messages and can
    /// ask for nothing else. Returns the address of a viewer's connection.
    ///
    /// # Errors
    /// [`Error::Serve`].
    pub fn serve(&mut self, address: IpAddr, port: u16) -> Result<String, Error> {
        let at = SocketAddr::new(address, port);
        let server =
            self.context.websocket_server().name("palpate").bind(address.to_string(), port);
        let server = server.start_blocking().map_err(|source| Error::Serve { at, source })?;
        let url = format!("ws://{}", SocketAddr::new(address, server.port()));
        self.server = Some(server);
        Ok(url)
    }

    /// Writes all that is published from now on into an MCAP file, which is empty yet.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&mut self, file: File) -> Result<(), Error> {
        let options =
            McapWriteOptions::new().profile("ros2").compression(Some(McapCompression::Zstd));
        let writer = self.context.mcap_writer_with_options(options).create(BufWriter::new(file));
        self.file = Some(writer.map_err(Error::Write)?);
        Ok(())
    }

    /// Ends the file, so that it can be read; gives it back, if there is one.
    ///
    /// # Errors
    /// [`Error::Write`] or [`Error::Disk`] if some of it is missing, as on a full disk.
    pub fn end_file(&mut self) -> Result<Option<File>, Error> {
        let Some(file) = self.file.take() else { return Ok(None) };
        let file = file.close().map_err(Error::Write)?;
        Ok(Some(file.into_inner().map_err(io::IntoInnerError::into_error)?))
    }
}

impl Default for Door {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            server.stop().wait_blocking();
        }
    }
}
