//! Why the journal is our own: the map of `sequential-storage` on the same flash, with the same loss of power.
//!
//! After an erase that was cut short, `embedded-storage` promises nothing about the sector. If its first word is still
//! programmed and its last one is not, the map takes it for the sector in use, and its repair erases the other one, which
//! has the only copy of the record. When this test fails, the crate can take the place of the journal.

mod mock;

use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use embedded_storage_async::nor_flash as nonblocking;
use mock::{MockError, MockFlash, Tear};
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use settings_store::SLOT_BYTES;

const SECTOR: usize = 4 * SLOT_BYTES;

type Flash = MockFlash<1, SECTOR>;
type UncachedMap<'a> = MapStorage<(), Ready<'a>, Cache<Uncached, Uncached, Uncached>>;

/// The flash with futures that are ready at once.
struct Ready<'a>(&'a mut Flash);

impl ErrorType for Ready<'_> {
    type Error = MockError;
}

impl nonblocking::ReadNorFlash for Ready<'_> {
    const READ_SIZE: usize = Flash::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MockError> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl nonblocking::NorFlash for Ready<'_> {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), MockError> {
        self.0.erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), MockError> {
        self.0.write(offset, bytes)
    }
}

fn ready<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => unreachable!("the flash is always ready"),
    }
}

fn map(flash: &mut Flash) -> UncachedMap<'_> {
    MapStorage::new(Ready(flash), MapConfig::new(Flash::RANGE), Cache::new_uncached())
}

fn save(flash: &mut Flash, record: &[u8]) -> Result<(), Error<MockError>> {
    ready(map(flash).store_item(&mut [0; SECTOR], &(), &record))
}

fn load(flash: &mut Flash) -> Result<Option<Vec<u8>>, Error<MockError>> {
    let mut buffer = [0; SECTOR];
    Ok(ready(map(flash).fetch_item::<&[u8]>(&mut buffer, &()))?.map(<[u8]>::to_vec))
}

/// How many cuts in a series of saves leave neither the record before nor the new one.
fn losses(tear: Tear) -> usize {
    let mut flash = Flash::erased();
    let mut losses = 0;
    save(&mut flash, &[0; 300]).unwrap();
    for number in 1..20_u8 {
        let (before, record) = ([number - 1; 300], [number; 300]);
        let mut whole = flash.clone();
        save(&mut whole, &record).unwrap();
        for cut in 0..whole.steps - flash.steps {
            let mut flash = flash.clone();
            flash.cut_after(cut, tear);
            save(&mut flash, &record).unwrap_err();
            flash.restart();
            let found = load(&mut flash).ok().flatten();
            losses += usize::from(found != Some(before.into()) && found != Some(record.into()));
        }
        flash = whole;
    }
    losses
}

#[test]
fn its_map_survives_cuts_in_order_and_loses_records_to_a_torn_erase() {
    assert_eq!(losses(Tear::Clean), 0);
    assert!(losses(Tear::Torn) > 0);
    assert!(losses(Tear::Backwards) > 0);
}
