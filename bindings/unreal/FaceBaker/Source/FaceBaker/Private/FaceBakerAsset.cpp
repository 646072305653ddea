#include "FaceBakerAsset.h"

#include "FaceBakerLog.h"
#include "UnrealFace.h"

DEFINE_LOG_CATEGORY(LogFaceBaker);

std::shared_ptr<const facebaker::Model> UFaceBakerAsset::Load() {
  std::shared_ptr<const facebaker::Model> Model = Loaded.lock();
  if (Model) return Model;
  std::string Error;
  Model = facebaker::unreal::load_archive(Archive.GetData(), static_cast<std::size_t>(Archive.Num()), Error);
  if (!Model) UE_LOG(LogFaceBaker, Error, TEXT("%s: %s"), *GetName(), UTF8_TO_TCHAR(Error.c_str()));
  Loaded = Model;
  return Model;
}

FString UFaceBakerAsset::WhatIsWrong(const TArray<uint8>& Bytes) {
  std::string Error;
  const auto Model = facebaker::unreal::load_archive(Bytes.GetData(), static_cast<std::size_t>(Bytes.Num()), Error);
  return Model ? FString() : FString(UTF8_TO_TCHAR(Error.c_str()));
}
