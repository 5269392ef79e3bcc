#!/usr/bin/env python3
"""Do two programs give the same results, bit by bit? For changes that are to leave results alone.

  scripts/compare-builds.py results PROGRAM OUT.json [--tree DIR] [--mocap DIR] [--only WORD ...] [--seconds S]
  scripts/compare-builds.py differ BEFORE.json AFTER.json

`results` runs PROGRAM (a release build of `throng`) on a copy of the tree's `data`: it builds every config, stitches every world,
runs every scene for S simulated seconds (8), exports the poses of some people of every scene, plans every task, and measures the hashes
of crowds. OUT.json has a hash for each result: sections of bundles and worlds one by one, what a report says without its times and
without the names of its keys, positions of joints. Configs that name captured motion need `--mocap`, the folder `shared/mocap`
beside a checkout, and are skipped without it. `differ` lists what differs, and exits 1 where anything does.
"""
import argparse, hashlib, json, os, re, shutil, struct, subprocess, sys, tempfile, zipfile

ROW = '<4sIQQII'
TIMES = re.compile(r'wall|per_second|^us_|_ns$|_us$|_ms$|seconds$|^seconds|steps_a_second|_bytes$|memory|milliseconds|ratio_to|^first_solution_s$|^total_s$')


def digest(data):
    return hashlib.sha256(data).hexdigest()[:16]


def values(report, key=''):
    """The values of a report in their order, without times; names of keys do not count."""
    if TIMES.search(key):
        return []
    if isinstance(report, dict):
        return [v for k in report for v in values(report[k], k)]
    if isinstance(report, list):
        return [v for item in report for v in values(item)] + ['end']
    return [report]


def sections(path):
    """Hash of each section of a bundle or world by its tag."""
    data = open(path, 'rb').read()
    found = {}
    count = struct.unpack_from('<I', data, 12)[0]
    for i in range(count):
        # A row of the section table: tag, element size, offset, count, checksum, zero.
        tag, size, offset, number, _, _ = struct.unpack_from(ROW, data, 64 + i * struct.calcsize(ROW))
        name = tag.decode(errors='replace')
        while name in found:
            name += "'"
        found[name] = digest(data[offset:offset + size * number])
    return found


class Runner:
    def __init__(self, args, root):
        self.program, self.root, self.args, self.found = os.path.abspath(args.program), root, args, {}

    def wanted(self, name):
        return not self.args.only or any(word in name for word in self.args.only)

    def run(self, *words):
        done = subprocess.run([self.program, *words], cwd=self.root, capture_output=True, text=True)
        if done.returncode:
            return None, done.stderr.strip().splitlines()[-1:] or ['failed']
        return done.stdout, None

    def note(self, name, value):
        self.found[name] = value
        print(f'{name}: {value if isinstance(value, str) else digest(json.dumps(value).encode())}', file=sys.stderr, flush=True)

    def report(self, name, *words):
        out, failed = self.run(*words, '--json')
        self.note(name, f'failed: {failed}' if failed else digest(json.dumps(values(json.loads(out))).encode()))

    def file(self, name, path, *words):
        out, failed = self.run(*words)
        self.note(name, f'failed: {failed}' if failed else sections(os.path.join(self.root, path)))

    def file_whole(self, name, path):
        path = os.path.join(self.root, path)
        if os.path.exists(path):
            self.note(name, digest(open(path, 'rb').read()))
            os.remove(path)

    def poses(self, name, scene):
        path = os.path.join(self.root, 'take.npz')
        if os.path.exists(path):
            os.remove(path)
        for people in ('0..7', '0..1', '0..0'):
            _, failed = self.run('export', scene, '--characters', people, '--from', '0', '--to', str(self.args.seconds / 2), '--fps', '30',
                                 '--format', 'npz', '--out', 'take.npz')
            if not failed:
                break
        if failed:
            if 'has no body' not in failed[0]:
                self.note(name, f'failed: {failed}')
            return
        with zipfile.ZipFile(path) as members:
            self.note(name, {m: digest(members.read(m)) for m in sorted(members.namelist()) if 'info' not in m and 'meta' not in m})


def results(args):
    root = tempfile.mkdtemp(prefix='throng-compare-')
    try:
        work = os.path.join(root, 'checkout')
        shutil.copytree(os.path.join(args.tree, 'data'), os.path.join(work, 'data'))
        if args.mocap:
            os.makedirs(os.path.join(root, 'shared'))
            os.symlink(os.path.abspath(args.mocap), os.path.join(root, 'shared', 'mocap'))
        runner = Runner(args, work)
        runner.run('synth', '--out', 'clips')
        data = os.path.join(work, 'data')
        for config in sorted(f for f in os.listdir(data) if f.endswith('.toml')):
            captured = 'shared/mocap' in open(os.path.join(data, config)).read()
            name = f'bundle {config}'
            if runner.wanted(name) and (args.mocap or not captured):
                bundle = config.replace('.toml', '.throng')
                runner.file(name, bundle, 'build', f'data/{config}', '--out', bundle)
        for world in sorted(os.listdir(os.path.join(data, 'worlds'))):
            if runner.wanted(f'world {world}'):
                runner.file(f'world {world}', f'{world}.world', 'stitch', f'data/worlds/{world}', '--out', f'{world}.world')
        for scene in sorted(os.listdir(os.path.join(data, 'scenes'))):
            if scene.endswith('.toml') and runner.wanted(f'scene {scene}'):
                runner.report(f'scene {scene}', 'run', f'data/scenes/{scene}', '--seconds', str(args.seconds))
            if scene.endswith('.toml') and runner.wanted(f'poses {scene}'):
                runner.poses(f'poses {scene}', f'data/scenes/{scene}')
        for task in sorted(os.listdir(os.path.join(data, 'tasks'))):
            if task.endswith('.toml') and runner.wanted(f'task {task}'):
                runner.report(f'task {task}', 'plan', f'data/tasks/{task}', '--out', 'planned.bvh')
                runner.file_whole(f'motion {task}', 'planned.bvh')
        for engine in ('events', 'occupancy'):
            if runner.wanted(f'engine {engine}'):
                for scene in ('lanes', 'bottleneck'):
                    runner.report(f'engine {engine} {scene}', 'run', f'data/scenes/{scene}.toml', '--engine', engine, '--seconds', '4')
        if runner.wanted('characters'):
            for bundle in ('walk', 'snu-walk', 'bandai-walk'):
                if os.path.exists(os.path.join(work, f'{bundle}.throng')):
                    for more in ([], ['--no-avoid'], ['--single-load']):
                        runner.report(f'characters {bundle} {" ".join(more)}', 'run', f'{bundle}.throng', '--characters', '300', '--seconds', '10', *more)
        with open(args.out, 'w') as file:
            json.dump(runner.found, file, indent=1, sort_keys=True)
    finally:
        shutil.rmtree(root, ignore_errors=True)


def differ(args):
    before, after = (json.load(open(f)) for f in (args.before, args.after))
    bad = 0
    for name in sorted(before.keys() | after.keys()):
        a, b = before.get(name), after.get(name)
        if a == b:
            continue
        bad += 1
        if isinstance(a, dict) and isinstance(b, dict):
            parts = [k for k in sorted(a.keys() | b.keys()) if a.get(k) != b.get(k)]
            print(f'{name}: {len(parts)} of {len(a)} parts differ: {", ".join(parts[:12])}')
        else:
            print(f'{name}: {a} before, {b} after')
    failed = sum(1 for v in after.values() if isinstance(v, str) and v.startswith('failed'))
    print(f'{len(after)} results, {bad} differ, {failed} failed')
    sys.exit(bad > 0)


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
kinds = parser.add_subparsers(required=True)
one = kinds.add_parser('results')
one.add_argument('program'); one.add_argument('out'); one.add_argument('--tree', default='.'); one.add_argument('--mocap')
one.add_argument('--only', nargs='*'); one.add_argument('--seconds', type=float, default=8.0); one.set_defaults(do=results)
two = kinds.add_parser('differ')
two.add_argument('before'); two.add_argument('after'); two.set_defaults(do=differ)
parsed = parser.parse_args()
parsed.do(parsed)
