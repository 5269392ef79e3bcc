//! Skeletons of many tools, joint by joint: `name;parent;place;role`.

/// Name of the convention and its joints.
pub const RIGS: [(&str, &str); 19] = [
    ("Character Creator", CHARACTER_CREATOR),
    ("Poser", POSER),
    ("DAZ Genesis 8", DAZ),
    ("Mixamo", MIXAMO),
    ("Xsens", XSENS),
    ("Rokoko", ROKOKO),
    ("Perception Neuron", NEURON),
    ("OptiTrack", OPTITRACK),
    ("HumanIK", HUMAN_IK),
    ("Rigify", RIGIFY),
    ("Rigify DEF", RIGIFY_DEF),
    ("3ds Max Biped", BIPED),
    ("CMU BVH", CMU_BVH),
    ("Unreal", UNREAL),
    ("Japanese", JAPANESE),
    ("German", GERMAN),
    ("Bone00", NUMBERED),
    ("two roots", TWO_ROOTS),
    ("six spine joints", LONG_SPINE),
];

const CHARACTER_CREATOR: &str = "
CC_Base_BoneRoot;-;0 0 0;-
CC_Base_Hip;CC_Base_BoneRoot;0 0.955 0;-
CC_Base_Pelvis;CC_Base_Hip;hips
CC_Base_{L,R}_Thigh;CC_Base_Pelvis;left_thigh
CC_Base_{L,R}_ThighTwist01;CC_Base_{L,R}_Thigh;0 -0.1 0;-
CC_Base_{L,R}_Calf;CC_Base_{L,R}_Thigh;left_shin
CC_Base_{L,R}_KneeShareBone;CC_Base_{L,R}_Calf;0 0 0.03;-
CC_Base_{L,R}_Foot;CC_Base_{L,R}_Calf;left_foot
CC_Base_{L,R}_ToeBase;CC_Base_{L,R}_Foot;left_toe
CC_Base_{L,R}_BigToe1;CC_Base_{L,R}_ToeBase;0 0 0.04;-
CC_Base_Waist;CC_Base_Hip;spine
CC_Base_Spine01;CC_Base_Waist;chest
CC_Base_Spine02;CC_Base_Spine01;upper_chest
CC_Base_{L,R}_Breast;CC_Base_Spine02;0.08 0.05 0.12;-
CC_Base_NeckTwist01;CC_Base_Spine02;neck
CC_Base_NeckTwist02;CC_Base_NeckTwist01;0 0.04 0;-
CC_Base_Head;CC_Base_NeckTwist02;head
CC_Base_JawRoot;CC_Base_Head;0 0.02 0.03;-
CC_Base_{L,R}_Eye;CC_Base_Head;0.03 0.07 0.06;-
CC_Base_{L,R}_Clavicle;CC_Base_Spine02;left_clavicle
CC_Base_{L,R}_Upperarm;CC_Base_{L,R}_Clavicle;left_upper_arm
CC_Base_{L,R}_UpperarmTwist01;CC_Base_{L,R}_Upperarm;0.1 0 0;-
CC_Base_{L,R}_Forearm;CC_Base_{L,R}_Upperarm;left_forearm
CC_Base_{L,R}_Hand;CC_Base_{L,R}_Forearm;left_hand
CC_Base_{L,R}_Mid1;CC_Base_{L,R}_Hand;0.09 0 0;-
CC_Base_{L,R}_Mid2;CC_Base_{L,R}_Mid1;0.04 0 0;-
CC_Base_{L,R}_Thumb1;CC_Base_{L,R}_Hand;0.03 0 0.03;-";

const POSER: &str = "
Body;-;0 0 0;-
hip;Body;hips
abdomen;hip;spine
chest;abdomen;0 0.2 0;upper_chest
neck;chest;neck
head;neck;head
{l,r}Eye;head;0.03 0.07 0.06;-
{l,r}Collar;chest;left_clavicle
{l,r}Shldr;{l,r}Collar;left_upper_arm
{l,r}ForeArm;{l,r}Shldr;left_forearm
{l,r}Hand;{l,r}ForeArm;left_hand
{l,r}Thumb1;{l,r}Hand;0.02 0 0.03;-
{l,r}Mid1;{l,r}Hand;0.08 0 0;-
{l,r}Mid2;{l,r}Mid1;0.04 0 0;-
{l,r}Buttock;hip;0.06 0 0;-
{l,r}Thigh;{l,r}Buttock;left_thigh
{l,r}Shin;{l,r}Thigh;left_shin
{l,r}Foot;{l,r}Shin;left_foot
{l,r}Toe;{l,r}Foot;left_toe";

const DAZ: &str = "
Genesis8Female;-;0 0 0;-
hip;Genesis8Female;0 1 0;-
pelvis;hip;hips
{l,r}ThighBend;pelvis;left_thigh
{l,r}ThighTwist;{l,r}ThighBend;0 -0.2 0;-
{l,r}Shin;{l,r}ThighTwist;left_shin
{l,r}Foot;{l,r}Shin;left_foot
{l,r}Metatarsals;{l,r}Foot;0 -0.03 0.05;-
{l,r}Toe;{l,r}Metatarsals;left_toe
{l,r}BigToe;{l,r}Toe;0.02 0 0.04;-
abdomenLower;hip;spine
abdomenUpper;abdomenLower;chest
chestLower;abdomenUpper;0 0.06 0;-
chestUpper;chestLower;upper_chest
{l,r}Pectoral;chestUpper;0.08 0 0.1;-
neckLower;chestUpper;neck
neckUpper;neckLower;0 0.04 0;-
head;neckUpper;head
lowerJaw;head;0 0.02 0.04;-
{l,r}Collar;chestUpper;left_clavicle
{l,r}ShldrBend;{l,r}Collar;left_upper_arm
{l,r}ShldrTwist;{l,r}ShldrBend;0.14 0 0;-
{l,r}ForearmBend;{l,r}ShldrTwist;left_forearm
{l,r}ForearmTwist;{l,r}ForearmBend;0.12 0 0;-
{l,r}Hand;{l,r}ForearmTwist;left_hand
{l,r}Carpal2;{l,r}Hand;0.04 0 0;-
{l,r}Mid1;{l,r}Carpal2;0.05 0 0;-
{l,r}Mid2;{l,r}Mid1;0.04 0 0;-
{l,r}Thumb1;{l,r}Hand;0.03 0 0.03;-";

const MIXAMO: &str = "
mixamorig:Hips;-;hips
mixamorig:Spine;mixamorig:Hips;spine
mixamorig:Spine1;mixamorig:Spine;chest
mixamorig:Spine2;mixamorig:Spine1;upper_chest
mixamorig:Neck;mixamorig:Spine2;neck
mixamorig:Head;mixamorig:Neck;head
mixamorig:HeadTop_End;mixamorig:Head;0 0.2 0;-
mixamorig:{Left,Right}Shoulder;mixamorig:Spine2;left_clavicle
mixamorig:{Left,Right}Arm;mixamorig:{Left,Right}Shoulder;left_upper_arm
mixamorig:{Left,Right}ForeArm;mixamorig:{Left,Right}Arm;left_forearm
mixamorig:{Left,Right}Hand;mixamorig:{Left,Right}ForeArm;left_hand
mixamorig:{Left,Right}HandIndex1;mixamorig:{Left,Right}Hand;0.09 0 0;-
mixamorig:{Left,Right}HandIndex2;mixamorig:{Left,Right}HandIndex1;0.04 0 0;-
mixamorig:{Left,Right}UpLeg;mixamorig:Hips;left_thigh
mixamorig:{Left,Right}Leg;mixamorig:{Left,Right}UpLeg;left_shin
mixamorig:{Left,Right}Foot;mixamorig:{Left,Right}Leg;left_foot
mixamorig:{Left,Right}ToeBase;mixamorig:{Left,Right}Foot;left_toe
mixamorig:{Left,Right}Toe_End;mixamorig:{Left,Right}ToeBase;0 0 0.07;-";

const XSENS: &str = "
Hips;-;hips
Chest;Hips;spine
Chest2;Chest;0 0.1 0;chest
Chest3;Chest2;0 0.1 0;-
Chest4;Chest3;0 0.1 0;upper_chest
Neck;Chest4;neck
Head;Neck;head
{Left,Right}Collar;Chest4;left_clavicle
{Left,Right}Shoulder;{Left,Right}Collar;left_upper_arm
{Left,Right}Elbow;{Left,Right}Shoulder;left_forearm
{Left,Right}Wrist;{Left,Right}Elbow;left_hand
{Left,Right}Hip;Hips;left_thigh
{Left,Right}Knee;{Left,Right}Hip;left_shin
{Left,Right}Ankle;{Left,Right}Knee;left_foot
{Left,Right}Toe;{Left,Right}Ankle;left_toe";

const ROKOKO: &str = "
Root;-;0 0 0;-
Hips;Root;hips
Spine1;Hips;spine
Spine2;Spine1;chest
Spine3;Spine2;0 0.06 0;-
Spine4;Spine3;upper_chest
Neck;Spine4;neck
Head;Neck;head
{Left,Right}Shoulder;Spine4;left_clavicle
{Left,Right}Arm;{Left,Right}Shoulder;left_upper_arm
{Left,Right}ForeArm;{Left,Right}Arm;left_forearm
{Left,Right}Hand;{Left,Right}ForeArm;left_hand
{Left,Right}Finger1Metacarpal;{Left,Right}Hand;0.02 0 0.02;-
{Left,Right}Finger1Proximal;{Left,Right}Finger1Metacarpal;0.04 0 0;-
{Left,Right}Thigh;Hips;left_thigh
{Left,Right}Shin;{Left,Right}Thigh;left_shin
{Left,Right}Foot;{Left,Right}Shin;left_foot
{Left,Right}Toe;{Left,Right}Foot;left_toe
{Left,Right}ToeTip;{Left,Right}Toe;0 0 0.06;-";

const NEURON: &str = "
Hips;-;hips
{Right,Left}UpLeg;Hips;right_thigh
{Right,Left}Leg;{Right,Left}UpLeg;right_shin
{Right,Left}Foot;{Right,Left}Leg;right_foot
Spine;Hips;spine
Spine1;Spine;chest
Spine2;Spine1;0 0.05 0;-
Spine3;Spine2;upper_chest
Neck;Spine3;neck
Head;Neck;head
{Right,Left}Shoulder;Spine3;right_clavicle
{Right,Left}Arm;{Right,Left}Shoulder;right_upper_arm
{Right,Left}ForeArm;{Right,Left}Arm;right_forearm
{Right,Left}Hand;{Right,Left}ForeArm;right_hand
{Right,Left}InHandMiddle;{Right,Left}Hand;-0.05 0 0;-
{Right,Left}HandMiddle1;{Right,Left}InHandMiddle;-0.04 0 0;-
{Right,Left}HandThumb1;{Right,Left}Hand;-0.02 0 0;-";

const OPTITRACK: &str = "
Skeleton;-;0 0 0;-
Hip;Skeleton;hips
Ab;Hip;spine
Chest;Ab;0 0.2 0;upper_chest
Neck;Chest;neck
Head;Neck;head
{L,R}Shoulder;Chest;left_clavicle
{L,R}UArm;{L,R}Shoulder;left_upper_arm
{L,R}FArm;{L,R}UArm;left_forearm
{L,R}Hand;{L,R}FArm;left_hand
{L,R}Thigh;Hip;left_thigh
{L,R}Shin;{L,R}Thigh;left_shin
{L,R}Foot;{L,R}Shin;left_foot
{L,R}Toe;{L,R}Foot;left_toe";

const HUMAN_IK: &str = "
Reference;-;0 0 0;-
Hips;Reference;hips
{Left,Right}UpLeg;Hips;left_thigh
{Left,Right}UpLegRoll;{Left,Right}UpLeg;0 -0.2 0;-
{Left,Right}Leg;{Left,Right}UpLeg;left_shin
{Left,Right}LegRoll;{Left,Right}Leg;0 -0.2 0;-
{Left,Right}Foot;{Left,Right}Leg;left_foot
{Left,Right}ToeBase;{Left,Right}Foot;left_toe
Spine;Hips;spine
Spine1;Spine;chest
Spine2;Spine1;upper_chest
{Left,Right}Shoulder;Spine2;left_clavicle
{Left,Right}Arm;{Left,Right}Shoulder;left_upper_arm
{Left,Right}ArmRoll;{Left,Right}Arm;0.14 0 0;-
{Left,Right}ForeArm;{Left,Right}Arm;left_forearm
{Left,Right}ForeArmRoll;{Left,Right}ForeArm;0.12 0 0;-
{Left,Right}Hand;{Left,Right}ForeArm;left_hand
Neck;Spine2;neck
Neck1;Neck;0 0.04 0;-
Head;Neck1;head";

const RIGIFY: &str = "
root;-;0 0 0;-
spine;root;hips
pelvis.{L,R};spine;0.05 0.02 0.02;-
thigh.{L,R};spine;left_thigh
shin.{L,R};thigh.{L,R};left_shin
foot.{L,R};shin.{L,R};left_foot
toe.{L,R};foot.{L,R};left_toe
heel.02.{L,R};foot.{L,R};0 -0.07 -0.03;-
spine.001;spine;spine
spine.002;spine.001;chest
spine.003;spine.002;upper_chest
breast.{L,R};spine.003;0.08 0.05 0.1;-
shoulder.{L,R};spine.003;left_clavicle
upper_arm.{L,R};shoulder.{L,R};left_upper_arm
forearm.{L,R};upper_arm.{L,R};left_forearm
hand.{L,R};forearm.{L,R};left_hand
palm.01.{L,R};hand.{L,R};0.03 0 0.02;-
f_index.01.{L,R};palm.01.{L,R};0.05 0 0;-
spine.004;spine.003;neck
spine.005;spine.004;0 0.05 0;-
spine.006;spine.005;head
face;spine.006;0 0.02 0;-
jaw;face;0 0 0.04;-";

const RIGIFY_DEF: &str = "
DEF-spine;-;hips
DEF-pelvis.{L,R};DEF-spine;0.05 0.02 0.02;-
DEF-thigh.{L,R};DEF-spine;left_thigh
DEF-thigh.{L,R}.001;DEF-thigh.{L,R};0 -0.21 0;-
DEF-shin.{L,R};DEF-thigh.{L,R}.001;left_shin
DEF-shin.{L,R}.001;DEF-shin.{L,R};0 -0.2 0;-
DEF-foot.{L,R};DEF-shin.{L,R}.001;left_foot
DEF-toe.{L,R};DEF-foot.{L,R};left_toe
DEF-spine.001;DEF-spine;spine
DEF-spine.002;DEF-spine.001;chest
DEF-spine.003;DEF-spine.002;upper_chest
DEF-shoulder.{L,R};DEF-spine.003;left_clavicle
DEF-upper_arm.{L,R};DEF-shoulder.{L,R};left_upper_arm
DEF-upper_arm.{L,R}.001;DEF-upper_arm.{L,R};0.14 0 0;-
DEF-forearm.{L,R};DEF-upper_arm.{L,R}.001;left_forearm
DEF-forearm.{L,R}.001;DEF-forearm.{L,R};0.12 0 0;-
DEF-hand.{L,R};DEF-forearm.{L,R}.001;left_hand
DEF-f_index.01.{L,R};DEF-hand.{L,R};0.09 0 0;-
DEF-spine.004;DEF-spine.003;neck
DEF-spine.006;DEF-spine.004;head";

const BIPED: &str = "
Bip01;-;0 0.955 0;-
Bip01 Pelvis;Bip01;hips
Bip01 Spine;Bip01 Pelvis;spine
Bip01 Spine1;Bip01 Spine;chest
Bip01 Spine2;Bip01 Spine1;upper_chest
Bip01 Neck;Bip01 Spine2;neck
Bip01 Head;Bip01 Neck;head
Bip01 HeadNub;Bip01 Head;0 0.2 0;-
Bip01 {L,R} Clavicle;Bip01 Neck;left_clavicle
Bip01 {L,R} UpperArm;Bip01 {L,R} Clavicle;left_upper_arm
Bip01 {L,R} Forearm;Bip01 {L,R} UpperArm;left_forearm
Bip01 {L,R} ForeTwist;Bip01 {L,R} Forearm;0.1 0 0;-
Bip01 {L,R} Hand;Bip01 {L,R} Forearm;left_hand
Bip01 {L,R} Finger0;Bip01 {L,R} Hand;0.02 0 0.03;-
Bip01 {L,R} Finger1;Bip01 {L,R} Hand;0.08 0 0;-
Bip01 {L,R} Finger11;Bip01 {L,R} Finger1;0.04 0 0;-
Bip01 {L,R} Thigh;Bip01 Pelvis;left_thigh
Bip01 {L,R} Calf;Bip01 {L,R} Thigh;left_shin
Bip01 {L,R} Foot;Bip01 {L,R} Calf;left_foot
Bip01 {L,R} Toe0;Bip01 {L,R} Foot;left_toe
Bip01 {L,R} Toe0Nub;Bip01 {L,R} Toe0;0 0 0.06;-
Bip01 Prop1;Bip01 R Hand;-0.1 0 0;-
Bone Prop Tip;Bip01 Prop1;0 0 1.1;-";

const CMU_BVH: &str = "
Hips;-;hips
{L,R}HipJoint;Hips;0 0 0;-
{Left,Right}UpLeg;{L,R}HipJoint;left_thigh
{Left,Right}Leg;{Left,Right}UpLeg;left_shin
{Left,Right}Foot;{Left,Right}Leg;left_foot
{Left,Right}ToeBase;{Left,Right}Foot;left_toe
LowerBack;Hips;0 0 0;spine
Spine;LowerBack;0 0.12 0;chest
Spine1;Spine;0 0.12 0;upper_chest
Neck;Spine1;0 0.02 0;neck
Neck1;Neck;0 0.1 0;-
Head;Neck1;head
{Left,Right}Shoulder;Spine1;0 0 0;left_clavicle
{Left,Right}Arm;{Left,Right}Shoulder;left_upper_arm
{Left,Right}ForeArm;{Left,Right}Arm;left_forearm
{Left,Right}Hand;{Left,Right}ForeArm;left_hand
{Left,Right}FingerBase;{Left,Right}Hand;0 0 0;-
{Left,Right}HandIndex1;{Left,Right}FingerBase;0.08 0 0;-
{L,R}Thumb;{Left,Right}Hand;0.03 0 0.02;-";

const UNREAL: &str = "
root;-;0 0 0;-
pelvis;root;hips
spine_01;pelvis;spine
spine_02;spine_01;chest
spine_03;spine_02;upper_chest
neck_01;spine_03;neck
head;neck_01;head
clavicle_{l,r};spine_03;left_clavicle
upperarm_{l,r};clavicle_{l,r};left_upper_arm
upperarm_twist_01_{l,r};upperarm_{l,r};0.1 0 0;-
lowerarm_{l,r};upperarm_{l,r};left_forearm
lowerarm_twist_01_{l,r};lowerarm_{l,r};0.1 0 0;-
hand_{l,r};lowerarm_{l,r};left_hand
middle_01_{l,r};hand_{l,r};0.09 0 0;-
middle_02_{l,r};middle_01_{l,r};0.04 0 0;-
weapon_{l,r};hand_{l,r};0.05 0 0;-
thigh_{l,r};pelvis;left_thigh
thigh_twist_01_{l,r};thigh_{l,r};0 -0.2 0;-
calf_{l,r};thigh_{l,r};left_shin
foot_{l,r};calf_{l,r};left_foot
ball_{l,r};foot_{l,r};left_toe
ik_foot_root;root;0 0 0;-
ik_foot_{l,r};ik_foot_root;left_foot;-
ik_hand_root;root;0 0 0;-
ik_hand_gun;ik_hand_root;right_hand;-
ik_hand_{l,r};ik_hand_gun;left_hand;-";

const JAPANESE: &str = "
全ての親;-;0 0 0;-
センター;全ての親;0 0.955 0;-
下半身;センター;hips
{左,右}足;下半身;left_thigh
{左,右}ひざ;{左,右}足;left_shin
{左,右}足首;{左,右}ひざ;left_foot
{左,右}つま先;{左,右}足首;left_toe
{左,右}足ＩＫ;全ての親;left_foot;-
上半身;センター;spine
上半身2;上半身;0 0.2 0;upper_chest
首;上半身2;neck
頭;首;head
{左,右}目;頭;0.03 0.07 0.06;-
{左,右}肩;上半身2;left_clavicle
{左,右}腕;{左,右}肩;left_upper_arm
{左,右}腕捩;{左,右}腕;0.14 0 0;-
{左,右}ひじ;{左,右}腕捩;left_forearm
{左,右}手捩;{左,右}ひじ;0.12 0 0;-
{左,右}手首;{左,右}手捩;left_hand
{左,右}人指１;{左,右}手首;0.08 0 0;-
{左,右}人指２;{左,右}人指１;0.04 0 0;-";

const GERMAN: &str = "
Wurzel;-;0 0 0;-
Becken;Wurzel;hips
Oberschenkel_{Links,Rechts};Becken;left_thigh
Unterschenkel_{Links,Rechts};Oberschenkel_{Links,Rechts};left_shin
Fuß_{Links,Rechts};Unterschenkel_{Links,Rechts};left_foot
Zehen_{Links,Rechts};Fuß_{Links,Rechts};left_toe
Wirbelsäule1;Becken;spine
Wirbelsäule2;Wirbelsäule1;chest
Brust;Wirbelsäule2;upper_chest
Hals;Brust;neck
Kopf;Hals;head
Schlüsselbein_{Links,Rechts};Brust;left_clavicle
Oberarm_{Links,Rechts};Schlüsselbein_{Links,Rechts};left_upper_arm
Unterarm_{Links,Rechts};Oberarm_{Links,Rechts};left_forearm
Hand_{Links,Rechts};Unterarm_{Links,Rechts};left_hand
Daumen_{Links,Rechts};Hand_{Links,Rechts};0.03 0 0.03;-
Zeigefinger_{Links,Rechts};Hand_{Links,Rechts};0.09 0 0;-";

const NUMBERED: &str = "
Bone00;-;hips
Bone01;Bone00;spine
Bone02;Bone01;chest
Bone03;Bone02;upper_chest
Bone{10,20};Bone03;left_clavicle
Bone{11,21};Bone{10,20};left_upper_arm
Bone{12,22};Bone{11,21};left_forearm
Bone{13,23};Bone{12,22};left_hand
Bone{14,24};Bone{13,23};0.09 0 0;-
Bone{15,25};Bone{14,24};0.04 0 0;-
Bone{16,26};Bone{13,23};0.03 0 0.03;-
Bone{17,27};Bone{16,26};0.03 0 0.01;-
Bone04;Bone03;neck
Bone05;Bone04;head
Bone06;Bone05;0 0.2 0;-
Bone{30,40};Bone00;left_thigh
Bone{31,41};Bone{30,40};left_shin
Bone{32,42};Bone{31,41};left_foot
Bone{33,43};Bone{32,42};left_toe";

const TWO_ROOTS: &str = "
World;-;0 0 0;-
Trajectory;World;0 0 0;-
Hips;Trajectory;hips
{L,R}_UpLeg;Hips;left_thigh
{L,R}_Leg;{L,R}_UpLeg;left_shin
{L,R}_Foot;{L,R}_Leg;left_foot
Torso;Hips;0 0.25 0;upper_chest
Head;Torso;head
{L,R}_Arm;Torso;left_upper_arm
{L,R}_Elbow;{L,R}_Arm;left_forearm
Ball;-;0.5 0.1 0.5;-
Ball_Spin;Ball;0 0.1 0;-";

const LONG_SPINE: &str = "
Pelvis;-;hips
{L,R}Leg0;Pelvis;0.03 0 0;-
{L,R}Leg1;{L,R}Leg0;left_thigh
{L,R}Leg2;{L,R}Leg1;left_shin
{L,R}Leg3;{L,R}Leg2;left_foot
Back1;Pelvis;spine
Back2;Back1;0 0.05 0;-
Back3;Back2;0 0.05 0;chest
Back4;Back3;0 0.05 0;-
Back5;Back4;0 0.05 0;-
Back6;Back5;upper_chest
Neck1;Back6;neck
Neck2;Neck1;0 0.03 0;-
Neck3;Neck2;0 0.03 0;-
Head;Neck3;head
{L,R}Arm0;Back6;left_clavicle
{L,R}Arm1;{L,R}Arm0;left_upper_arm
{L,R}Arm2;{L,R}Arm1;left_forearm
{L,R}Arm3;{L,R}Arm2;left_hand";

/// Figures of games and drawn figures, whose limbs have any proportions and whose joints are named as their parts. (name, joints)
pub const DRAWN: [(&str, &str); 7] = [
    ("game figure", GAME),
    ("short upper arms", SHORT_UPPER_ARMS),
    ("stub forearms", STUB_FOREARMS),
    ("long shins", LONG_SHINS),
    ("shoulders wide", WIDE_SHOULDERS),
    ("palms", PALMS),
    ("arms above shoulders", ARMS_ABOVE_SHOULDERS),
];

const GAME: &str = "
Root;-;0 0 0;-
Hips;Root;hips
Abdomen;Hips;spine
Torso;Abdomen;0 0.2 0;upper_chest
Neck;Torso;neck
Head;Neck;head
Shoulder.{L,R};Torso;0.03 0.13 0;left_clavicle
UpperArm.{L,R};Shoulder.{L,R};0.15 0 0;left_upper_arm
LowerArm.{L,R};UpperArm.{L,R};0.28 0 0;left_forearm
Hand.{L,R};LowerArm.{L,R};0.14 0 0;left_hand
UpperLeg.{L,R};Hips;left_thigh
LowerLeg.{L,R};UpperLeg.{L,R};left_shin
Foot.{L,R};LowerLeg.{L,R};left_foot";

const SHORT_UPPER_ARMS: &str = "
Hips;-;hips
Spine;Hips;spine
Chest;Spine;0 0.2 0;upper_chest
Neck;Chest;neck
Head;Neck;head
Shoulder.{L,R};Chest;0.02 0.13 0;left_clavicle
UpperArm.{L,R};Shoulder.{L,R};0.2 0 0;left_upper_arm
LowerArm.{L,R};UpperArm.{L,R};0.18 0 0;left_forearm
Hand.{L,R};LowerArm.{L,R};0.36 0 0;left_hand
UpperLeg.{L,R};Hips;left_thigh
LowerLeg.{L,R};UpperLeg.{L,R};left_shin
Foot.{L,R};LowerLeg.{L,R};left_foot
Toes.{L,R};Foot.{L,R};left_toe";

const STUB_FOREARMS: &str = "
Hips;-;hips
Spine;Hips;spine
Chest;Spine;0 0.2 0;upper_chest
Neck;Chest;neck
Head;Neck;head
Shoulder.{L,R};Chest;0.02 0.13 0;left_clavicle
UpperArm.{L,R};Shoulder.{L,R};0.24 0 0;left_upper_arm
LowerArm.{L,R};UpperArm.{L,R};0.26 0 0;left_forearm
Hand.{L,R};LowerArm.{L,R};0.08 0 0;left_hand
Grip.{L,R};Hand.{L,R};0.2 0 0;-
UpperLeg.{L,R};Hips;left_thigh
LowerLeg.{L,R};UpperLeg.{L,R};left_shin
Foot.{L,R};LowerLeg.{L,R};left_foot
Toes.{L,R};Foot.{L,R};left_toe";

const LONG_SHINS: &str = "
pelvis;-;0 0.8 0;hips
spine;pelvis;0 0.1 0;spine
chest;spine;0 0.2 0;upper_chest
neck;chest;0 0.2 0;neck
head;neck;0 0.1 0;head
clavicle_{l,r};chest;0.03 0.13 0;left_clavicle
upperarm_{l,r};clavicle_{l,r};0.12 0 0;left_upper_arm
lowerarm_{l,r};upperarm_{l,r};0.3 0 0;left_forearm
hand_{l,r};lowerarm_{l,r};0.11 0 0;left_hand
thigh_{l,r};pelvis;0.1 -0.02 0;left_thigh
calf_{l,r};thigh_{l,r};0 -0.2 0;left_shin
foot_{l,r};calf_{l,r};0 -0.5 0;left_foot
ball_{l,r};foot_{l,r};0 -0.06 0.14;left_toe";

const WIDE_SHOULDERS: &str = "
Hips;-;hips
Spine;Hips;spine
Chest;Spine;0 0.2 0;upper_chest
Neck;Chest;neck
Head;Neck;head
{Left,Right}Shoulder;Chest;0.02 0.13 0;left_clavicle
{Left,Right}UpperArm;{Left,Right}Shoulder;0.32 0 0;left_upper_arm
{Left,Right}LowerArm;{Left,Right}UpperArm;0.3 0 0;left_forearm
{Left,Right}Hand;{Left,Right}LowerArm;0.12 0 0;left_hand
{Left,Right}UpperLeg;Hips;left_thigh
{Left,Right}LowerLeg;{Left,Right}UpperLeg;left_shin
{Left,Right}Foot;{Left,Right}LowerLeg;left_foot
{Left,Right}Toes;{Left,Right}Foot;left_toe";

const PALMS: &str = "
Body;-;0 0 0;-
Hips;Body;hips
Abdomen;Hips;spine
Torso;Abdomen;0 0.2 0;upper_chest
Neck;Torso;neck
Head;Neck;head
Shoulder{L,R};Torso;0.05 0.13 0;left_clavicle
UpperArm{L,R};Shoulder{L,R};0.2 0 0;left_upper_arm
LowerArm{L,R};UpperArm{L,R};0.2 0 0;left_forearm
Palm{L,R};LowerArm{L,R};0.36 0 0;left_hand
Middle1{L,R};Palm{L,R};0.1 0 0;-
Middle2{L,R};Middle1{L,R};0.1 0 0;-
UpperLeg{L,R};Hips;left_thigh
LowerLeg{L,R};UpperLeg{L,R};left_shin
Foot{L,R};LowerLeg{L,R};left_foot";

const ARMS_ABOVE_SHOULDERS: &str = "
Hips;-;hips
Spine;Hips;spine
Chest;Spine;0 0.2 0;upper_chest
Neck;Chest;neck
Head;Neck;head
Arm.{L,R};Chest;0.02 0.13 0;left_clavicle
Shoulder.{L,R};Arm.{L,R};0.16 0 0;left_upper_arm
Elbow.{L,R};Shoulder.{L,R};0.28 0 0;left_forearm
Wrist.{L,R};Elbow.{L,R};0.25 0 0;left_hand
Leg.{L,R};Hips;left_thigh
Knee.{L,R};Leg.{L,R};left_shin
Ankle.{L,R};Knee.{L,R};left_foot
Toe.{L,R};Ankle.{L,R};left_toe";
