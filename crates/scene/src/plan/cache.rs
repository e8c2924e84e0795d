//! Values that are made when they are first asked for.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Values by what they are.
#[derive(Debug)]
pub(super) struct Cache<K, V>(RefCell<BTreeMap<K, Rc<V>>>);

impl<K: Ord + Clone, V> Cache<K, V> {
    pub(super) fn new() -> Self {
        Self(RefCell::new(BTreeMap::new()))
    }

    /// The value of a key; to make it, others may be asked for.
    pub(super) fn of(&self, key: &K, make: impl FnOnce() -> V) -> Rc<V> {
        let known = self.0.borrow().get(key).map(Rc::clone);
        known.unwrap_or_else(|| {
            let value = Rc::new(make());
            let mut values = self.0.borrow_mut();
            Rc::clone(values.entry(key.clone()).or_insert(value))
        })
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_value_is_made_once_and_may_be_made_of_others() {
        let (cache, n_made) = (Cache::new(), Cell::new(0));
        let two = |key: i32| {
            *cache.of(&key, || {
                n_made.set(n_made.get() + 1);
                2 * *cache.of(&(key - 1), || 20)
            })
        };
        assert_eq!([two(5), two(5)], [40; 2]);
        assert_eq!((two(4), n_made.get()), (20, 1));
    }
}
