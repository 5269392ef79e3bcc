//! A binary heap whose keys can be lowered, over numbers below a limit; its memory is allocated once.

/// The least key first; of equal keys, the least number.
#[derive(Clone, Debug)]
pub(crate) struct Heap {
    items: Vec<(f32, u32)>,
    /// Place of each number in `items`, or anything where it is not there.
    places: Vec<u32>,
}

impl Heap {
    /// Memory for the numbers below `limit`.
    pub fn new(limit: usize) -> Self {
        Self { items: Vec::with_capacity(limit), places: vec![0; limit] }
    }

    pub fn clear(&mut self) {
        self.items.clear();
    }

    /// Adds a number, or lowers its key (number < limit, key is not NaN).
    pub fn push(&mut self, number: u32, key: f32) {
        let place = self.places[number as usize] as usize;
        let place = match self.items.get(place) {
            Some(item) if item.1 == number => {
                self.items[place].0 = key;
                place
            }
            _ => {
                self.items.push((key, number));
                self.items.len() - 1
            }
        };
        self.rise(place);
    }

    /// Removes the number with the least key and returns it.
    pub fn pop(&mut self) -> Option<(f32, u32)> {
        let last = self.items.pop()?;
        let Some(first) = self.items.first_mut() else { return Some(last) };
        let out = std::mem::replace(first, last);
        self.sink();
        Some(out)
    }

    fn rise(&mut self, mut place: usize) {
        let item = self.items[place];
        while place > 0 && before(item, self.items[(place - 1) / 2]) {
            self.move_item((place - 1) / 2, place);
            place = (place - 1) / 2;
        }
        self.items[place] = item;
        self.places[item.1 as usize] = place as u32;
    }

    fn sink(&mut self) {
        let item = self.items[0];
        let mut place = 0;
        loop {
            let (left, right) = (2 * place + 1, 2 * place + 2);
            let Some(&l) = self.items.get(left) else { break };
            let least = if self.items.get(right).is_some_and(|&r| before(r, l)) { right } else { left };
            if !before(self.items[least], item) {
                break;
            }
            self.move_item(least, place);
            place = least;
        }
        self.items[place] = item;
        self.places[item.1 as usize] = place as u32;
    }

    fn move_item(&mut self, from: usize, to: usize) {
        self.items[to] = self.items[from];
        self.places[self.items[to].1 as usize] = to as u32;
    }
}

fn before(a: (f32, u32), b: (f32, u32)) -> bool {
    a.0 < b.0 || a.0 == b.0 && a.1 < b.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_come_out_by_their_lowest_key(pushes in prop::collection::vec((0u32..40, 0u32..100), 0..200)) {
            let mut heap = Heap::new(40);
            let mut keys = std::collections::BTreeMap::new();
            for (number, key) in pushes {
                let key = key.min(*keys.get(&number).unwrap_or(&u32::MAX));
                keys.insert(number, key);
                heap.push(number, key as f32);
            }
            let mut expected: Vec<_> = keys.into_iter().map(|(n, k)| (k as f32, n)).collect();
            expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let found: Vec<_> = std::iter::from_fn(|| heap.pop()).collect();
            prop_assert_eq!(found, expected);
        }
    }
}
