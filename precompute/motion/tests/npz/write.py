# Writes AMASS-like files and, by forward kinematics of its own, where the joints are (Y up).
import sys

import numpy as np

out = sys.argv[1]
rng = np.random.default_rng(3)
T = 40
names = "Pelvis L_Hip R_Hip Spine1 L_Knee R_Knee Spine2 L_Ankle R_Ankle Spine3 L_Foot R_Foot Neck L_Collar R_Collar Head L_Shoulder R_Shoulder L_Elbow R_Elbow L_Wrist R_Wrist".split()
parents = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]
off = {
    "Pelvis": (0, 0, 0),
    "Spine1": (0, 0.095, 0),
    "Spine2": (0, 0.125, 0),
    "Spine3": (0, 0.13, 0),
    "Neck": (0, 0.19, 0),
    "Head": (0, 0.09, 0.015),
}
for s, p in ((1, "L"), (-1, "R")):
    off[p + "_Collar"] = (s * 0.03, 0.14, 0)
    off[p + "_Shoulder"] = (s * 0.155, 0, 0)
    off[p + "_Elbow"] = (s * 0.29, 0, 0)
    off[p + "_Wrist"] = (s * 0.255, 0, 0)
    off[p + "_Hip"] = (s * 0.092, -0.045, 0)
    off[p + "_Knee"] = (0, -0.42, 0)
    off[p + "_Ankle"] = (0, -0.41, 0)
    off[p + "_Foot"] = (0, -0.06, 0.135)
off = np.array([off[n] for n in names])


def rot(v):
    a = np.linalg.norm(v)
    if a < 1e-12:
        return np.eye(3)
    x, y, z = v / a
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(a) * K + (1 - np.cos(a)) * K @ K


t = np.arange(T)[:, None] * 0.1
poses = np.zeros((T, 156))
amp = rng.uniform(-0.3, 0.3, (1, 66))
ph = rng.uniform(0, 6, (1, 66))
poses[:, :66] = amp * np.sin(t + ph)
for f in range(T):  # stand up: Y-up body to a Z-up world, then turn about the vertical
    R = rot(np.array([0, 0, 0.05 * f])) @ rot(np.array([np.pi / 2, 0, 0])) @ rot(poses[f, :3] * 0.3)
    ang = np.arccos((np.trace(R) - 1) / 2)
    ax = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (2 * np.sin(ang))
    poses[f, :3] = ax * ang
trans = np.concatenate([np.sin(t), 0.03 * np.arange(T)[:, None], 0.95 + 0.02 * np.cos(t)], 1)


def fk(poses, trans):
    res = []
    Y = rot(np.array([-np.pi / 2, 0, 0]))
    for f in range(T):
        P = [None] * 22
        R = [None] * 22
        for j in range(22):
            r = rot(poses[f, 3 * j : 3 * j + 3])
            if j == 0:
                R[0] = Y @ r
                P[0] = Y @ trans[f]
            else:
                R[j] = R[parents[j]] @ r
                P[j] = P[parents[j]] + R[parents[j]] @ off[j]
        res.append(np.array(P).ravel())
    return np.array(res)


np.savez(
    out + "/amass.npz",
    poses=poses,
    trans=trans,
    mocap_framerate=np.array(60.0),
    gender=np.array("neutral"),
    betas=np.zeros(16),
    dmpls=np.zeros((T, 8)),
)
np.savez(
    out + "/smplx.npz",
    root_orient=poses[:, :3].astype(np.float32),
    pose_body=poses[:, 3:66].astype(np.float32),
    trans=trans.astype(np.float32),
    mocap_frame_rate=np.int64(60),
    surface_model_type="smplx",
)
np.savez_compressed(out + "/packed.npz", poses=poses, trans=trans, mocap_framerate=60.0)
np.savez(out + "/columns.npz", poses=np.asfortranarray(poses), trans=trans, mocap_framerate=60.0)
np.savez(out + "/norate.npz", poses=poses, trans=trans)
np.savez(out + "/short.npz", poses=poses[:, :60], trans=trans, mocap_framerate=60.0)
np.savetxt(out + "/truth.csv", fk(poses, trans), delimiter=",")
