#include "proxies/body_info.h"
#include "proxies/catalogue_tables.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/scan3d.h"

namespace rack {

namespace {

using namespace tims::class_id;
constexpr i8 kData = tims::type::kData;

constexpr MessageInfo kMessages[] = {
    {kFeatureMap, kData, "DATA", kBody<FeatureMapData>},
    {kFeatureMap, FeatureMapType::kLoadMap, "LOAD_MAP", kBody<FileName>},
    {kFeatureMap, FeatureMapType::kAddLine, "ADD_LINE", kBody<FeatureMapFeature>},
    {kFeatureMap, FeatureMapType::kSaveMap, "SAVE_MAP", kBody<FileName>},
    {kFeatureMap, FeatureMapType::kGiveMap, "GIVE_MAP"},
    {kFeatureMap, FeatureMapType::kDeleteLine, "DELETE_LINE", kBody<FeatureMapFeature>},
    {kFeatureMap, FeatureMapType::kDisplaceLine, "DISPLACE_LINE", kBody<FeatureMapFeature>},
    {kFeatureMap, FeatureMapType::kGetLayer, "GET_LAYER"},
    {kFeatureMap, FeatureMapType::kSetLayer, "SET_LAYER", kBody<FeatureMapLayerData>},
    {kFeatureMap, FeatureMapType::kLayer, "LAYER", kBody<FeatureMapLayerData>},

    {kGridMap, kData, "DATA", kBody<GridMapData>},

    {kMcl, kData, "DATA", kBody<MclData>},
    {kMcl, MclType::kLoadMap, "LOAD_MAP", kBody<FileName>},

    {kObjRecog, kData, "DATA", kBody<ObjRecogData>},
    {kObjRecog, ObjRecogType::kSetEstimate, "SET_ESTIMATE", kBody<ObjRecogData>},
    {kObjRecog, ObjRecogType::kStopRecog, "STOP_RECOG", kBody<ObjRecogData>},

    {kScan2d, kData, "DATA", kBody<Scan2dData>},

    {kScan3d, kData, "DATA", kBody<Scan3dData>},
    {kScan3d, Scan3dType::kGetRangeImage, "GET_RANGE_IMAGE"},
    {kScan3d, Scan3dType::kStoreData, "STORE_DATA"},
    {kScan3d, Scan3dType::kRangeImage, "RANGE_IMAGE", kBody<Scan3dRangeImageData>},
};

}  // namespace

std::span<const MessageInfo> perception_messages() { return kMessages; }

}  // namespace rack
